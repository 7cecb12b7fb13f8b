//! Design of strokes: optimal strokes, learned ones and derivatives against exact values.

mod learned;
mod optimal;
mod sensitivities;
mod sizes;
mod speed;
mod tables;
mod timing;
mod turning;
