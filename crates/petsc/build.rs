//! Finds PETSc and MPI by pkg-config and passes PETSc's configuration on as `cfg` flags.

use std::path::PathBuf;
use std::process::{Command, exit};

/// What to do where PETSc is missing.
const REMEDY: &str = "install PETSc 3.18 or later with real numbers, and an MPI; on Debian: \
    apt-get install petsc-dev libopenmpi-dev openmpi-bin; elsewhere add the folder of PETSc.pc to \
    PKG_CONFIG_PATH";

fn main() {
    println!("cargo:rerun-if-env-changed=PKG_CONFIG_PATH");
    let petsc = pkg_config("PETSc");
    link(&petsc);
    link(&pkg_config("ompi-c").or_else(|| pkg_config("mpich")));
    let header = petsc
        .iter()
        .flatten()
        .filter_map(|word| word.strip_prefix("-I"))
        .map(|folder| PathBuf::from(folder).join("petscconf.h"))
        .find_map(|file| std::fs::read_to_string(file).ok());
    let Some(header) = header else {
        return fail("petscconf.h is not in the include folders that pkg-config names");
    };
    let defines = |name: &str| {
        let mut words = header.lines().map(|line| line.split_whitespace().nth(1));
        words.any(|word| word == Some(name))
    };
    if defines("PETSC_USE_COMPLEX") || !defines("PETSC_USE_REAL_DOUBLE") {
        fail("this PETSc is not built for real numbers in double precision");
    }
    if defines("PETSC_USE_64BIT_INDICES") {
        println!("cargo:rustc-cfg=petsc_64_bit");
    }
    if defines("PETSC_HAVE_MPICH") || defines("PETSC_HAVE_MPICH_NUMVERSION") {
        println!("cargo:rustc-cfg=petsc_mpich");
    }
}

/// Flags of a package; none if pkg-config does not know it.
fn pkg_config(package: &str) -> Option<Vec<String>> {
    let output = Command::new("pkg-config")
        .args(["--cflags", "--libs", package])
        .output()
        .ok()
        .filter(|output| output.status.success())?;
    let text = String::from_utf8(output.stdout).ok()?;
    Some(text.split_whitespace().map(str::to_owned).collect())
}

/// Passes folders and names of libraries to the linker.
fn link(flags: &Option<Vec<String>>) {
    let Some(flags) = flags else {
        return fail("pkg-config finds no PETSc, or neither Open MPI (ompi-c) nor MPICH (mpich)");
    };
    for flag in flags {
        if let Some(folder) = flag.strip_prefix("-L") {
            println!("cargo:rustc-link-search=native={folder}");
            println!("cargo:rustc-link-arg=-Wl,-rpath,{folder}");
        } else if let Some(library) = flag.strip_prefix("-l") {
            println!("cargo:rustc-link-lib={library}");
        }
    }
}

fn fail(what: &str) {
    println!("cargo:warning={what}: {REMEDY}");
    eprintln!("{what}: {REMEDY}");
    exit(1);
}
