"""Files as strangers may have made them, and as ours have to be: whole, sealed, known again."""

from typing import TYPE_CHECKING

from harness.face import face_of

if TYPE_CHECKING:
    from harness.files.apart import run_apart as run_apart
    from harness.files.bounded import (
        names_in_hdf5 as names_in_hdf5,
        open_regular as open_regular,
        parse_json as parse_json,
        read_bytes as read_bytes,
        reading as reading,
    )
    from harness.registry.allowed import (
        require_allowed as require_allowed,
        require_program as require_program,
    )
else:
    __all__, __getattr__ = face_of(__name__)
