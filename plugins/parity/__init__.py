"""How far simulators differ that are told the same."""

from typing import TYPE_CHECKING

from harness.face import face_of

if TYPE_CHECKING:
    from .contenders import Missing as Missing, choose_contenders as choose_contenders
    from .orders import Setting as Setting
    from .page import parity_table as parity_table, write_parity as write_parity
    from .parity import compare_simulators as compare_simulators
else:
    __all__, __getattr__ = face_of(__name__)
