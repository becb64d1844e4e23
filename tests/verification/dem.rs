//! Verification cases of dem-node.
