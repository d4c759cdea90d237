//! Addresses where only paths are accepted, in a program with and without the feature `remote`.

use crate::cli::Folder;

/// 3 commands refuse an address, or a path, that they cannot use, and name the command that can.
#[test]
fn unusable_addresses_name_a_command_that_fits() {
    let folder = Folder::new();
    folder.refused(
        "replay s3://b/site.helio --weather s3://b/x.epw",
        &["only archives are read from addresses", "heliotile archive copy"],
    );
    folder.refused("archive merge a.helio b.helio -o s3://b/c.helio", &["only `archive copy` writes to addresses"]);
    folder.refused("archive copy a.helio b.helio", &["a.helio"]);
}
