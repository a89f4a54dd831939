//! kinora-kernel
