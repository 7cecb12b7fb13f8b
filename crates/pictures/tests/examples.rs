//! The examples run.

#[path = "../examples/page_of_a_run.rs"]
mod page_of_a_run;

#[test]
fn a_run_writes_its_page() {
    page_of_a_run::main().unwrap();
}
