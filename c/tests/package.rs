//! What CMake installs: found by `find_package(dpn)` and by pkg-config.
#![allow(clippy::unwrap_used)]

use std::path::{Path, PathBuf};
use std::process::Command;

fn done(command: &mut Command) -> String {
    let output = command.output().unwrap();
    let words = [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes).into_owned());
    assert!(output.status.success(), "{command:?}: {}{}", words[0], words[1]);
    words[0].clone()
}

fn is_there(program: &str) -> bool {
    Command::new(program).arg("--version").output().is_ok_and(|output| output.status.success())
}

#[test]
fn a_program_of_another_project_finds_the_installed_library() {
    if !is_there("cmake") {
        eprintln!("skipped: no cmake");
        return;
    }
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let built: PathBuf = std::env::current_exe().unwrap().parent().unwrap().to_owned();
    let dir = tempfile::tempdir().unwrap();
    let [package, place, other] = ["package", "place", "other"].map(|name| dir.path().join(name));
    let cmake = || Command::new("cmake");
    let built = format!("-DDPN_BUILT={}", built.display());
    done(cmake().arg("-S").arg(here).arg("-B").arg(&package).arg(built));
    done(cmake().arg("--install").arg(&package).arg("--prefix").arg(&place));

    std::fs::create_dir(&other).unwrap();
    let lists = "cmake_minimum_required(VERSION 3.16)\nproject(other CXX)\nset(CMAKE_CXX_STANDARD 17)\nfind_package(dpn 0.2 REQUIRED)\n\
        add_executable(other main.cpp)\ntarget_link_libraries(other dpn::dpn)\n";
    std::fs::write(other.join("CMakeLists.txt"), lists).unwrap();
    let main =
        "#include <cstdio>\n#include <dpn.hpp>\nint main() { std::puts(dpn_version()); dpn::Level level; }\n";
    std::fs::write(other.join("main.cpp"), main).unwrap();
    let found = format!("-DCMAKE_PREFIX_PATH={}", place.display());
    let build = other.join("build");
    done(cmake().arg("-S").arg(&other).arg("-B").arg(&build).arg(found));
    done(cmake().arg("--build").arg(&build));
    let version = format!("{}\n", env!("CARGO_PKG_VERSION"));
    assert_eq!(done(&mut Command::new(build.join("other"))), version);

    if is_there("pkg-config") {
        let lib = std::fs::read_dir(&place).unwrap().map(|entry| entry.unwrap().path());
        let lib = lib.into_iter().find(|path| path.join("pkgconfig").is_dir()).unwrap();
        let mut asked = Command::new("pkg-config");
        let flags =
            done(asked.args(["--cflags", "--libs", "dpn"]).env("PKG_CONFIG_PATH", lib.join("pkgconfig")));
        let program = dir.path().join("by-pkg-config");
        let mut compiler = Command::new("g++");
        compiler.arg("-std=c++17").arg(other.join("main.cpp")).arg("-o").arg(&program);
        done(compiler.args(flags.split_whitespace()));
        assert_eq!(done(Command::new(&program).env("LD_LIBRARY_PATH", &lib)), version);
    }
}
