//! What one evaluation may use up. A scene cannot raise its own limits.

/// Steps: about a second.
pub const FUEL: u64 = 20_000_000;
/// Calls of functions and prefabs inside one another.
pub const CALLS: u32 = 256;
/// Everything that is evaluated inside one another: bounds the stack, [`STACK_BYTES`].
pub const DEPTH: u32 = 12_000;
/// Of the thread that evaluates; the system gives it page by page, as it is used.
pub const STACK_BYTES: usize = 256 << 20;
/// Turns of one loop.
pub const LOOP: u64 = 1_000_000;
/// Nodes of a scene.
pub const NODES: usize = 1_000_000;
/// Instances of a scene, those of one place in a loop together being one node.
pub const INSTANCES: usize = 10_000_000;
/// Items of a list, those of its lists included.
pub const LIST: usize = 1_000_000;
/// Lists and tuples inside one another.
pub const NESTING: u32 = 64;
/// Different operations on what moves.
pub const OPERATIONS: usize = 4_000_000;
/// Groups inside one another.
pub const GROUPS: u32 = 4096;
/// Materials inside one another: coats and mixes.
pub const LAYERS: usize = 32;
/// Bytes of a text.
pub const TEXT: usize = 64 << 10;
/// Keys of a curve.
pub const KEYS: usize = 100_000;
/// Triangles of a mesh.
pub const TRIANGLES: usize = 100_000_000;
/// The greatest whole number: up to here f64 is exact.
pub const WHOLE: f64 = 9_007_199_254_740_992.0;
/// Files of a scene.
pub const FILES: usize = 256;
/// Files that import one another in a row, the scene not counted.
pub const IMPORTS_DEEP: usize = 32;
/// Bytes that a scene may take while it is rendered, where nothing is known of the machine.
pub const MEMORY: u64 = 8 << 30;
/// Bytes of all texts of a scene together.
pub const TEXT_OF_ALL_FILES: u32 = 1 << 30;
