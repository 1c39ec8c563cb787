//! The two-level BVH on the CPU against brute force, and its layout for shaders. Without Vulkan.

#[path = "../bvh_support/mod.rs"]
mod bvh_support;

mod brute_force;
mod gpu_layout;
mod thin_surfaces;
