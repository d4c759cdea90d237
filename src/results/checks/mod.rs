//! Whether an archive is what it says, and how it is made so again. In: archives, their scenes. Out: what an independent judge finds of their
//! errors; a damaged archive made whole.

mod audit;
mod original;
mod repair;

pub use audit::{
    AuditReport, AuditRequest, ComponentErrors, HourKindErrors, SkyViewErrors, Verdict, WorstPair, is_time,
};
pub use repair::{RepairDone, RepairRequest};
