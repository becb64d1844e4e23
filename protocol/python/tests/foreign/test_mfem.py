"""An MFEM rail of curved elements of second and higher order under the layer of `quick`. Needs the wheel mfem."""

import unittest

from adapters import FOREIGN, Adapter, adapter
from second_order import SETTLEMENT_M, SecondOrder, settled


class Mfem(SecondOrder, Adapter):
    code = "mfem"

    def test_fourth_order_is_more_accurate_with_as_many_nodes(self):
        # Measured: 3.0e-4 with order 2, 2.7e-5 with order 4.
        _, sunk = settled(adapter(FOREIGN / "mfem" / "rail.py"), 4, 1.6e-3, 5, 3)
        self.assertLess(abs(sunk / SETTLEMENT_M - 1.0), 6e-5)


if __name__ == "__main__":
    unittest.main()
