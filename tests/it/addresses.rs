//! A program that is built without the feature `remote`.

use crate::cli::Folder;

/// 6 commands refuse an address with how to build a program that reads it, without a signature; a scene, weather and an output at an address are
/// refused for what they are.
#[test]
fn without_the_feature() {
    let folder = Folder::new();
    let address = "https://me:secret@host/site.helio?sig=secret";
    let build = ["https://host/site.helio: is an address", "cargo build --locked --release --features remote"];
    for line in
        ["info AT", "verify AT", "query AT --conditions conditions.csv", "view AT", "copy AT a.helio", "diff AT AT"]
    {
        folder.refused(&line.replace("AT", address), &build);
        assert!(!crate::cli::stderr(&folder.run(&line.replace("AT", address))).contains("secret"), "{line}");
    }
    folder.refused(
        "replay s3://b/site.helio --weather s3://b/x.epw",
        &["only archives are read from there", "heliotile copy"],
    );
    folder.refused("merge a.helio b.helio -o s3://b/c.helio", &["to which only `copy` writes"]);
    folder.refused("copy a.helio b.helio", &["a.helio"]);
}
