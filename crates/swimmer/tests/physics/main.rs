//! Exact properties of Stokes flow, held by the finite-element model on coarse meshes.
//!
//! A property that discretisation keeps is tested to the error of the solves, one that it keeps to its order to that.

mod balance;
mod dragged;
mod frames;
mod mobility;
mod reproducible;
mod scenes;
mod strokes;
