"""New plugins: packages that work and pass their tests as they are written, for their authors to change."""
