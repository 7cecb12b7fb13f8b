//! All tests of the public interface but that of memory, which counts every allocation.

mod construction;
mod examples;
mod hostile;
mod properties;
mod quality;
#[cfg(feature = "serde")]
mod serde_feature;
mod shapes;

mod io {
    mod dialects;
    mod encode;
    mod malformed;
    mod real_files;
    mod regions;
    mod vtu_files;
}
