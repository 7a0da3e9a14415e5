//! The command line: parse, run, print the error chain and its hint, exit code. Nothing else.

fn main() {}
