//! What every `Link` must do.
