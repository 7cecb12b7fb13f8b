//! The end of every help text: examples, and the exit codes.
//!
//! Every example runs in an empty folder after the lines above it; a test does that.

/// The exit codes, see [`swimmer::SwimError::exit_code`].
macro_rules! exit_codes {
    () => {
        "Exit codes:
  0    done
  2    bad input; the message names the place and the remedy
  3    the method failed, and the message says how
  130  interrupted, for example by Ctrl-C"
    };
}

/// Examples, one command per line, and the exit codes.
macro_rules! examples {
    ($($command:literal)+) => {
        concat!("Examples:\n", $("  ", $command, "\n",)+ "\n", exit_codes!())
    };
}

pub const SCHEMA: &str = examples! {
    "swim schema"
    "swim schema run > run.schema.json"
};

pub const SWIM: &str = examples! {
    "swim new three-sphere"
    "swim check three-sphere.toml"
    "swim run three-sphere.toml"
};

pub const RUN: &str = examples! {
    "swim new three-sphere"
    "swim run three-sphere.toml"
    "swim run three-sphere.toml --set gait.cycles=3 --out out/three-cycles"
    "swim run three-sphere.toml --json --quiet > summary.json"
    "swim run three-sphere.toml --sensitivities"
};

pub const VIEW: &str = examples! {
    "swim new three-sphere"
    "swim run three-sphere.toml"
    "swim view out/three-sphere"
    "swim view out/three-sphere --movie"
};

pub const SOLVE: &str = examples! {
    "swim new three-sphere"
    "swim solve three-sphere.toml"
    "swim solve three-sphere.toml --resistance --json"
    "swim solve three-sphere.toml --flow flow.vtu --picture flow.svg"
};

pub const MAP: &str = examples! {
    "swim new optimal-stroke"
    "swim map optimal-stroke.toml"
    "swim map optimal-stroke.toml --set optimise.lower=3 --out out/wider --json"
    "swim map optimal-stroke.toml --out out/shared --shard 1/2"
    "swim map optimal-stroke.toml --out out/shared --shard 2/2"
};

pub const OPTIMISE: &str = examples! {
    "swim new optimal-stroke"
    "swim optimise optimal-stroke.toml"
    "swim run out/optimal-stroke/optimum.toml"
};

pub const FREQUENCY: &str = examples! {
    "swim new elastic-arm"
    "swim frequency elastic-arm.toml --set model.tolerance=1e-2"
};

pub const SIZES: &str = examples! {
    "swim new three-sphere"
    "swim sizes three-sphere.toml --set 'optimise.radii=[0.5, 2]'"
    "swim run out/three-sphere/optimum.toml"
};

pub const SWEEP: &str = examples! {
    "swim new three-sphere"
    "swim sweep three-sphere.toml --set model.kind=rpy --vary bodies.centre.radius=0.5:2:7"
    "swim sweep three-sphere.toml --set model.kind=rpy --vary 'bodies.left.radius=0.5:2' --random 9"
    "swim sweep three-sphere.toml --set model.kind=rpy --vary links.left-arm.length=7:10:4"
};

pub const LEARN: &str = examples! {
    "swim new learning"
    "swim learn learning.toml"
    "swim learn learning.toml --set learn.method=double-q --json"
};

pub const CHECK: &str = examples! {
    "swim new three-sphere"
    "swim check three-sphere.toml"
    "swim check three-sphere.toml --set model.tolerance=1e-8"
};

pub const NEW: &str = examples! {
    "swim new --list"
    "swim new three-sphere"
    "swim new purcell --out hinges.toml"
};

pub const MESH: &str = examples! {
    "swim new three-sphere"
    "swim mesh three-sphere.toml --set model.kind=fem --out mesh.vtu"
};

pub const COMPLETIONS: &str = examples! {
    "swim completions bash > swim.bash"
    "swim completions zsh > _swim"
};

pub const MAN: &str = examples! {
    "swim man man/man1"
};
