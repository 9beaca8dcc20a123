//! Style and script of the page.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use sha2::{Digest, Sha256};

/// Inside `<style>`.
pub(super) const STYLE: &str = include_str!("page.css");
/// Inside `<script>`.
pub(super) const SCRIPT: &str = include_str!("page.js");

/// What the page may do: run this script and no other, whatever a file's name brings, and load nothing.
pub(super) fn policy() -> String {
    let hash = STANDARD.encode(Sha256::digest(SCRIPT));
    format!("default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'sha256-{hash}'")
}
