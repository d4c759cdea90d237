//! Files: unpacked on the way in, whole or absent on the way out, sorted beyond memory.
//!
//! | module | in | out |
//! | --- | --- | --- |
//! | [`input`] | a path | bytes, unpacked; for a path that leads nowhere, similar names |
//! | [`csv_rows`] | a CSV file | its records, each with its line |
//! | [`spill`] | records | the records in order, with temporary files when they do not fit in memory |
//! | [`writing`] | outputs of a run | claims on them; files that appear when they are whole |
//! | [`text`] | bytes of a text | text in UTF-8, short quotations |

#![deny(missing_docs)]

pub mod csv_rows;
pub mod input;
pub mod spill;
pub mod text;
pub mod writing;
