//! Checks and repairs of archives. In: archives, their scenes. Out: the errors of an archive
//! measured by an independent reference path tracer; a repaired archive.

mod audit;
mod original;
mod repair;

pub use audit::{
    AuditReport, AuditRequest, ComponentErrors, HourKindErrors, SkyViewErrors, Verdict, WorstPair, is_time,
};
pub use repair::{RepairDone, RepairRequest};
