"""Files as strangers may have made them, and as ours have to be: whole, sealed, known again."""

from harness.files.bounded import (
    digest_of,
    is_inside,
    is_partial,
    is_plain,
    kind_at,
    open_regular,
    read_json,
    read_text,
    reading,
    require_regular,
    twins,
    whole_files,
    write_whole,
)
from harness.files.plain import Plain
from harness.files.sealed import (
    changed_since_made,
    forget_made,
    making,
    note_made,
    read_sealed,
    read_sums,
    seal,
    unseal,
)

__all__ = [
    "Plain",
    "changed_since_made",
    "digest_of",
    "forget_made",
    "is_inside",
    "is_partial",
    "is_plain",
    "kind_at",
    "making",
    "note_made",
    "open_regular",
    "read_json",
    "read_sealed",
    "read_sums",
    "read_text",
    "reading",
    "require_regular",
    "seal",
    "twins",
    "unseal",
    "whole_files",
    "write_whole",
]
