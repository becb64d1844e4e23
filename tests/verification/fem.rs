//! Verification cases of fem-node.
