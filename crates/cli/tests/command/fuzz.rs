//! The corpora of the fuzz targets of files of the program are read or refused, without a panic.

use swimmer::Folder;

#[path = "../../../../fuzz/src/corpus.rs"]
mod corpus;
#[path = "../../../../fuzz/src/own_files.rs"]
mod own_files;

#[test]
fn the_corpus_of_flow_slices_is_read_or_refused() {
    corpus::replay("flow_slices", own_files::read_flow_slices);
}

/// Mutations of a table that is refused reach nothing behind it. Where the format has changed,
/// `fuzz/own_files.py` writes the corpus again.
#[test]
fn the_corpus_of_tables_is_read_or_refused() {
    let whole = include_str!("../../../../fuzz/corpus/table/whole.json");
    let temporary = tempfile::tempdir().unwrap();
    std::fs::write(temporary.path().join("table.json"), whole).unwrap();
    let folder = Folder::create(temporary.path()).unwrap();
    own_files::table_in(&folder).unwrap();
    corpus::replay("table", own_files::read_table);
}
