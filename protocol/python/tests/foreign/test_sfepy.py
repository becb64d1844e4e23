"""A SfePy rail of curved biquadratic elements under the layer of `quick`. Run by hand, because pip builds sfepy from its sources."""

import importlib.util
import unittest

from adapters import Adapter
from second_order import SecondOrder


@unittest.skipUnless(importlib.util.find_spec("sfepy"), "sfepy is not installed; see scenarios/foreign/sfepy/scenario.toml")
class Sfepy(SecondOrder, Adapter):
    code = "sfepy"


if __name__ == "__main__":
    unittest.main()
