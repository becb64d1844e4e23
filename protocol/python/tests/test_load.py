"""Reading runs: a short one of the built program, both encodings of fields, and what is missing or damaged."""

import os
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import numpy as np
from program import PROGRAM, ROOT, Program

import thirdbody
from thirdbody.fields import read_vtk
from thirdbody.table import Table, read_table

SHORT = {"run.end_s": 2e-4}


class Load(Program):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.run_dir = cls.work / "short"
        thirdbody.run(ROOT / "scenarios" / "quick", SHORT, out=cls.run_dir, program=PROGRAM)

    def setUp(self):
        self.loaded = thirdbody.load(self.run_dir)
        environment = mock.patch.dict(os.environ, {"THIRDBODY": PROGRAM})
        environment.start()
        self.addCleanup(environment.stop)

    def copy(self, name):
        folder = self.work / name
        shutil.copytree(self.run_dir, folder)
        return folder

    def test_scenario_and_manifest_belong_to_the_run(self):
        self.assertEqual(self.loaded.scenario["run"]["end_s"], SHORT["run.end_s"])
        self.assertEqual(self.loaded.participants, ["rail", "third-body"])
        self.assertEqual(self.loaded.interfaces, ["layer-base"])
        self.assertEqual(self.loaded.manifest["seed"], self.loaded.scenario["run"]["seed"])
        self.assertEqual(self.loaded.summary["hashes"]["scenario"], self.loaded.manifest["scenario_hash"])

    def test_the_error_for_an_unknown_name_proposes_the_nearest_one(self):
        for look, meant in (
            (lambda: self.loaded.results["approach_m"], "results: backbone_bodies"),
            (lambda: self.loaded.results["diskz"], "did you mean `disks`?"),
            (lambda: self.loaded.signals["interface_fyn"], "did you mean `interface_fy_n`?"),
            (lambda: self.loaded.signals.column("wheel_z_m"), "did you mean `wheel_"),
        ):
            with self.assertRaises(KeyError) as caught:
                look()
            self.assertIn(meant, str(caught.exception))

    def test_forces_of_the_log_sum_up_to_the_signal(self):
        # The signal has enough digits for every bit; the sum over points is done in another order.
        interface, signals = self.loaded.interface(), self.loaded.signals
        np.testing.assert_array_equal(interface.t_s, signals["t_s"])
        for name in self.loaded.participants:
            total = interface[name].force_n.sum(axis=1)
            np.testing.assert_allclose(total[:, 0], signals["interface_fx_n"], rtol=0, atol=1e-10 * np.abs(total).max())
            np.testing.assert_allclose(total[:, 1], signals["interface_fy_n"], rtol=0, atol=1e-10 * np.abs(total).max())

    def test_displacements_of_the_log_equal_the_fields(self):
        field, side = self.loaded.fields("rail")["end"], self.loaded.interface()["rail"]
        places = [int(np.argmin(np.linalg.norm(field["points_m"] - point, axis=1))) for point in side.points_m]
        np.testing.assert_allclose(field["points_m"][places], side.points_m, rtol=0, atol=1e-15)
        largest = np.abs(side.displacement_m[-1]).max()
        self.assertGreater(largest, 1e-7)
        np.testing.assert_allclose(field["displacement_m"][places], side.displacement_m[-1], rtol=0, atol=1e-9 * largest)

    def test_velocities_of_the_layer_are_increments_over_windows(self):
        interface = self.loaded.interface("layer-base")
        layer = interface["third-body"]
        spans_s = (interface.t_s - interface.t0_s)[1:, None, None]
        np.testing.assert_allclose(
            layer.displacement_m[1:], layer.displacement_m[:-1] + spans_s * layer.velocity_m_per_s[1:], rtol=0, atol=1e-9 * np.abs(layer.displacement_m).max()
        )

    def test_the_wheel_of_mcap_and_the_export_give_the_same_bits(self):
        try:
            import mcap  # noqa: F401
        except ImportError:
            self.fail("the tests need the wheels of requirements.txt")
        read = self.loaded.interface()
        with mock.patch.dict(sys.modules, {"mcap.reader": None}):
            exported = self.loaded.interface()
        for name, side in read.sides.items():
            for array in ("points_m", "displacement_m", "velocity_m_per_s", "force_n"):
                np.testing.assert_array_equal(getattr(side, array), getattr(exported[name], array), err_msg=f"{name}.{array}")

    def test_two_interfaces_of_one_layer_have_their_own_points(self):
        run = thirdbody.run(ROOT / "scenarios" / "two-rails", {"run.end_s": 2e-5}, out=self.work / "two", program=PROGRAM)
        for name, continuum in (("below", "lower"), ("above", "upper")):
            interface = run.interface(name)
            self.assertEqual(sorted(interface.sides), sorted([continuum, "third-body"]))
            total = interface["third-body"].force_n.sum(axis=1)
            np.testing.assert_allclose(total[:, 1], run.signals[f"{name}.interface_fy_n"], rtol=1e-9, atol=1e-9)
            heights = interface["third-body"].points_m[:, 1]
            self.assertLess(np.ptp(heights), 2.1e-4, "one row of grains, not both")

    def test_contacts_join_grains_that_touch(self):
        fields = self.loaded.fields("third-body")
        self.assertEqual(fields.names[-1], "end")
        self.assertAlmostEqual(fields.t_s[-1], self.loaded.signals["t_s"][-1], delta=1e-12)
        field = fields["end"]
        a, b = field["contacts"].T
        gap = np.linalg.norm(field["points_m"][a] - field["points_m"][b], axis=1) - field["radius_m"][a] - field["radius_m"][b]
        # Overlaps are a few hundredths of a radius; grains that do not touch would be whole radii apart.
        self.assertLess(np.abs(gap).max(), 0.05 * field["radius_m"].mean())
        self.assertEqual(len(field["force_n"]), len(field["contacts"]))
        self.assertGreater(field["force_n"][:, 0].min(), 0.0)

    def test_an_interrupted_run_gives_the_data_it_has(self):
        folder = self.copy("interrupted")
        (folder / "summary.json").unlink()
        signals = (folder / "signals.csv").read_text()
        (folder / "signals.csv").write_text(signals[: len(signals) // 2].rstrip("\n")[:-3])
        log = (folder / "exchange.mcap").read_bytes()
        (folder / "exchange.mcap").write_bytes(log[: 2 * len(log) // 3])
        run = thirdbody.load(folder)
        self.assertEqual((run.status, run.summary), ("unfinished", {}))
        rows = len(run.signals["t_s"])
        self.assertTrue(0 < rows < len(self.loaded.signals["t_s"]))
        np.testing.assert_array_equal(run.signals["t_s"], self.loaded.signals["t_s"][:rows])
        with self.assertRaisesRegex(ValueError, "no results.*killed or still runs"):
            run.results
        interface, whole = run.interface(), self.loaded.interface()
        self.assertRegex(interface.damage, "ends early")
        count = len(interface.t_s)
        self.assertTrue(0 < count < len(whole.t_s))
        np.testing.assert_array_equal(interface["rail"].force_n, whole["rail"].force_n[:count])

    def test_the_error_names_what_is_missing(self):
        folder = self.copy("without")
        (folder / "exchange.mcap").unlink()
        (folder / "fields" / "third-body.pvd").rename(folder / "fields" / "third-body.vtkhdf")
        run = thirdbody.load(folder)
        for problem, words, ask in [
            (FileNotFoundError, "exchange.mcap is missing.*removed", lambda: run.interface()),
            (KeyError, "no interface `top`; interfaces: layer-base", lambda: run.interface("top")),
            (KeyError, "no participant `wheel`; participants: rail, third-body", lambda: run.fields("wheel")),
            (KeyError, "no moment `hold` of `rail`; moments: end", lambda: run.fields("rail")["hold"]),
            (KeyError, "no array `speed`; arrays: points_m", lambda: run.fields("rail")["end"]["speed"]),
            (FileNotFoundError, "third-body.vtkhdf beside it.*h5py", lambda: run.fields("third-body")),
            (KeyError, "no column `speed`; columns: t_s", lambda: run.signals.column("speed")),
            (FileNotFoundError, "profile-top.csv is missing; status of the run", lambda: run.profile_of("top")),
            (FileNotFoundError, "neither summary.json nor manifest.json", lambda: thirdbody.load(self.work)),
            (FileNotFoundError, "is not a folder", lambda: thirdbody.load(self.work / "nowhere")),
        ]:
            with self.subTest(words), self.assertRaisesRegex(problem, words):
                ask()

    def test_the_error_for_a_run_without_a_log_names_the_key_that_switched_it_off(self):
        keys = {"run.end_s": 1e-5, "run.output.exchange": False}
        run = thirdbody.run(ROOT / "scenarios" / "quick", keys, out=self.work / "unlogged", program=PROGRAM)
        with self.assertRaisesRegex(FileNotFoundError, "run.output.exchange = false switched it off"):
            run.interface()

    def test_numpy_alone_reads_a_run(self):
        script = (
            "import sys, thirdbody; run = thirdbody.load(sys.argv[1]); run.signals, run.fields('rail')[-1];"
            "print(sorted({'iceoryx2', 'xxhash', 'pandas', 'mcap'} & set(sys.modules)))"
        )
        environment = {**os.environ, "PYTHONPATH": str(ROOT / "protocol" / "python")}
        done = subprocess.run([sys.executable, "-c", script, str(self.run_dir)], env=environment, capture_output=True, text=True)
        self.assertEqual(done.stdout, "[]\n", done.stderr)


class Encodings(unittest.TestCase):
    """Two quadrilaterals, and two grains with a contact, written by hand in both encodings."""

    BODY = ("UnstructuredGrid", 'NumberOfPoints="6" NumberOfCells="2"', [
        ("Points", "points", "Float64", 3, [0, 0, 0, 1, 0, 0, 2, 0, 0, 0, 1, 0, 1, 1, 0, 2, 1e-300, 0]),
        ("Cells", "connectivity", "Int64", 1, [0, 1, 4, 3, 1, 2, 5, 4]),
        ("Cells", "offsets", "Int64", 1, [4, 8]),
        ("Cells", "types", "UInt8", 1, [9, 9]),
        ("PointData", "displacement_m", "Float64", 3, [0.1, -0.25, 0] * 6),
        ("CellData", "hydrostatic_pressure_pa", "Float64", 1, [6.5e8, -1.0 / 3.0]),
    ])
    GRAINS = ("PolyData", 'NumberOfPoints="2" NumberOfVerts="2" NumberOfLines="1"', [
        ("Points", "points", "Float64", 3, [0, 0, 0, 1e-4, 0, 0]),
        ("Verts", "connectivity", "Int64", 1, [0, 1]),
        ("Verts", "offsets", "Int64", 1, [1, 2]),
        ("Lines", "connectivity", "Int64", 1, [0, 1]),
        ("Lines", "offsets", "Int64", 1, [2]),
        ("PointData", "radius_m", "Float64", 1, [5e-5, 5.5e-5]),
        ("PointData", "glued", "UInt8", 1, [1, 0]),
        ("CellData", "force_n", "Float64", 2, [0, 0, 0, 0, 12.5, -0.1]),
    ])

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def written(self, document, appended, header="UInt64"):
        """A file of this document."""
        kind, counts, arrays = document
        blocks, parts = b"", {}
        for part, name, number, components, values in arrays:
            head = f'<DataArray type="{number}" Name="{name}" NumberOfComponents="{components}"'
            if appended:
                data = np.array(values, dtype={"Float64": "<f8", "Int64": "<i8", "UInt8": "u1"}[number]).tobytes()
                element = f'{head} format="appended" offset="{len(blocks)}"/>'
                blocks += len(data).to_bytes(8 if header == "UInt64" else 4, "little") + data
            else:
                element = f'{head} format="ascii">{" ".join(map(repr, values))}</DataArray>'
            parts[part] = parts.get(part, "") + element
        body = "".join(f"<{part}>{elements}</{part}>" for part, elements in parts.items())
        text = f'<VTKFile type="{kind}" version="1.0" byte_order="LittleEndian" header_type="{header}"><{kind}><Piece {counts}>{body}</Piece></{kind}>'
        end = b'<AppendedData encoding="raw">\n_' + blocks + b"\n</AppendedData>" if appended else b""
        path = self.folder / f"{'raw' if appended else 'ascii'}.{'vtu' if kind == 'UnstructuredGrid' else 'vtp'}"
        path.write_bytes(text.encode() + end + b"</VTKFile>\n")
        return path

    def test_both_encodings_give_the_numbers_that_were_written(self):
        for appended, header in ((False, "UInt64"), (True, "UInt64"), (True, "UInt32")):
            with self.subTest(appended=appended, header=header):
                body = read_vtk(self.written(self.BODY, appended, header))
                self.assertEqual(list(body), ["points_m", "quads", "displacement_m", "hydrostatic_pressure_pa"])
                np.testing.assert_array_equal(body["points_m"][-1], [2.0, 1e-300])
                np.testing.assert_array_equal(body["quads"], [[0, 1, 4, 3], [1, 2, 5, 4]])
                np.testing.assert_array_equal(body["displacement_m"], [[0.1, -0.25]] * 6)
                np.testing.assert_array_equal(body["hydrostatic_pressure_pa"], [6.5e8, -1.0 / 3.0])
                grains = read_vtk(self.written(self.GRAINS, appended, header))
                np.testing.assert_array_equal(grains["contacts"], [[0, 1]])
                np.testing.assert_array_equal(grains["force_n"], [[12.5, -0.1]])
                np.testing.assert_array_equal(grains["radius_m"], [5e-5, 5.5e-5])
                self.assertEqual(grains["glued"].tolist(), [1, 0])

    def test_bytes_that_look_like_tags_are_numbers(self):
        tricky = np.frombuffer(b"</VTKF><", dtype="<f8")[0]
        kind, counts, arrays = self.BODY
        arrays = arrays[:-1] + [(*arrays[-1][:4], [float(tricky), 1.0])]
        body = read_vtk(self.written((kind, counts, arrays), True))
        np.testing.assert_array_equal(body["hydrostatic_pressure_pa"], [tricky, 1.0])

    def test_the_error_names_a_truncated_or_changed_file(self):
        raw, text = (self.written(self.BODY, appended).read_bytes() for appended in (True, False))
        cut = self.folder / "cut.vtu"
        for data, words in [
            (raw[:-35], r"cut\.vtu, array `hydrostatic_pressure_pa` at offset \d+: \d+ bytes instead of 16.*cut off"),
            (raw[: raw.index(b"<Appended") + 40].replace(b"_", b""), "appended data are missing"),
            (raw.replace(b'"raw"', b'"base64"'), "not raw"),
            (text[: len(text) // 2], r"cut\.vtu cannot be read.*killed"),
            (text.replace(b"650000000.0", b"6,5"), "`hydrostatic_pressure_pa` is not ASCII numbers"),
            (text.replace(b"<VTKFile ", b'<VTKFile compressor="vtkZLibDataCompressor" '), "compressed"),
            (text.replace(b'"Int64"', b'"Int128"'), "type `Int128` are unknown"),
            (text.replace(b"0.1 -0.25", b"0.1", 1), "not make rows of 3"),
        ]:
            cut.write_bytes(data)
            with self.subTest(words), self.assertRaisesRegex(ValueError, words):
                read_vtk(cut)


class Tables(unittest.TestCase):
    def test_columns_are_found_by_the_end_of_their_name(self):
        table = Table(t_s=np.zeros(2), **{"a.force_n": np.ones(2), "b.force_n": np.ones(2), "b.way_m": np.full(2, 3.0)})
        np.testing.assert_array_equal(table.column("way_m"), [3.0, 3.0])
        with self.assertRaisesRegex(KeyError, "several columns `force_n`: a.force_n, b.force_n"):
            table.column("force_n")

    def test_a_data_frame_needs_pandas(self):
        with mock.patch.dict(sys.modules, {"pandas": None}), self.assertRaisesRegex(ImportError, "pip install pandas"):
            Table(t_s=np.zeros(2)).to_pandas()

    def test_a_line_with_too_few_values_in_the_middle_is_damage(self):
        with mock.patch("builtins.open", mock.mock_open(read_data="a,b\n1,2\n3\n4,5\n")):
            with self.assertRaisesRegex(ValueError, "line 3 has 1 values for 2 columns"):
                read_table(Path("signals.csv"))


if __name__ == "__main__":
    unittest.main()
