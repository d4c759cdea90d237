// Made by tools/faces from the requests. Do not edit.
#![doc = include_str!("commands.md")]

#[doc = include_str!("run.md")]
pub mod run {}

#[doc = include_str!("pv.md")]
pub mod pv {}

#[doc = include_str!("energyplus.md")]
pub mod energyplus {}

#[doc = include_str!("receivers.md")]
pub mod receivers {}

#[doc = include_str!("build.md")]
pub mod build {}

#[doc = include_str!("plan.md")]
pub mod plan {}

#[doc = include_str!("update.md")]
pub mod update {}

#[doc = include_str!("query.md")]
pub mod query {}

#[doc = include_str!("replay.md")]
pub mod replay {}

#[doc = include_str!("compare.md")]
pub mod compare {}

#[doc = include_str!("sunlight.md")]
pub mod sunlight {}

#[doc = include_str!("glare.md")]
pub mod glare {}

#[doc = include_str!("comfort.md")]
pub mod comfort {}

#[doc = include_str!("factors.md")]
pub mod factors {}

#[doc = include_str!("buildings.md")]
pub mod buildings {}

#[doc = include_str!("places.md")]
pub mod places {}

#[doc = include_str!("rules.md")]
pub mod rules {}

#[doc = include_str!("info.md")]
pub mod info {}

#[doc = include_str!("verify.md")]
pub mod verify {}

#[doc = include_str!("audit.md")]
pub mod audit {}

#[doc = include_str!("tradeoff.md")]
pub mod tradeoff {}

#[doc = include_str!("diff.md")]
pub mod diff {}

#[doc = include_str!("repair.md")]
pub mod repair {}

#[doc = include_str!("view.md")]
pub mod view {}

#[doc = include_str!("export.md")]
pub mod export {}

#[doc = include_str!("extract.md")]
pub mod extract {}

#[doc = include_str!("merge.md")]
pub mod merge {}

#[doc = include_str!("copy.md")]
pub mod copy {}

#[doc = include_str!("partition.md")]
pub mod partition {}

#[doc = include_str!("find.md")]
pub mod find {}

#[doc = include_str!("catalogue.md")]
pub mod catalogue {}
