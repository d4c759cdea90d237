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

#[doc = include_str!("update.md")]
pub mod update {}

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

#[doc = include_str!("energyplus-factors.md")]
pub mod energyplus_factors {}

#[doc = include_str!("buildings.md")]
pub mod buildings {}

#[doc = include_str!("places.md")]
pub mod places {}

#[doc = include_str!("info.md")]
pub mod info {}

#[doc = include_str!("archive-verify.md")]
pub mod archive_verify {}

#[doc = include_str!("archive-audit.md")]
pub mod archive_audit {}

#[doc = include_str!("tradeoff.md")]
pub mod tradeoff {}

#[doc = include_str!("archive-diff.md")]
pub mod archive_diff {}

#[doc = include_str!("archive-repair.md")]
pub mod archive_repair {}

#[doc = include_str!("view.md")]
pub mod view {}

#[doc = include_str!("export.md")]
pub mod export {}

#[doc = include_str!("archive-extract.md")]
pub mod archive_extract {}

#[doc = include_str!("archive-merge.md")]
pub mod archive_merge {}

#[doc = include_str!("archive-copy.md")]
pub mod archive_copy {}

#[doc = include_str!("atlas-partition.md")]
pub mod atlas_partition {}

#[doc = include_str!("atlas-find.md")]
pub mod atlas_find {}

#[doc = include_str!("atlas-catalogue.md")]
pub mod atlas_catalogue {}
