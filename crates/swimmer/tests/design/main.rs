//! Design of strokes: optimal strokes and learned ones against exact values.

mod learned;
mod optimal;
