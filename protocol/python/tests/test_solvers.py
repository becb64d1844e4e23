"""The base classes: repeats, columns, checkpoints, compliant boundaries, and refusals."""

import unittest

import numpy as np

import thirdbody
from thirdbody import Config, ConfigurationError, Diverged, Points, Setting, Window
from thirdbody.state import digest, from_bytes, to_bytes

SETTING = Setting("me", 1, 1e-3, 1, None)


def window(index=0, iteration=0, substeps=4):
    return Window(index, iteration, 4 * index, substeps, 2.0 * index, 2.0 * index + 0.5 * substeps)


class Mass(thirdbody.Continuum):
    """One free mass of 2 kg, symplectic Euler, which may spoil its state."""

    step_s = 0.5
    careless = False

    def points(self, set_name):
        return Points([0.0], [0.0], mass_kg=2.0, length_m=1.0)

    def rest(self):
        return {"u": np.zeros((1, 2)), "v": np.array([[1.0, 0.0]])}

    def step(self, state, force, n):
        u, v = state["u"], state["v"]
        for _ in range(n):
            if self.careless:
                v += self.step_s * force / 2.0
            else:
                v = v + self.step_s * force / 2.0
            u = u + self.step_s * v
        return {"u": u, "v": v}

    def displacement(self, state):
        return state["u"]

    def energy(self, state):
        return {"stored": {"kinetic": float((state["v"] ** 2).sum()) - 1.0}}


def ready(cls, **keys):
    node = cls(Config(keys), SETTING)
    node.begin()
    node.couple(node.sets[0])
    return node


class Continua(unittest.TestCase):
    def test_a_repeat_begins_where_the_window_began(self):
        node = ready(Mass)
        first = node.advance(window(), np.array([4.0, 0.0]))
        other = node.advance(window(0, 1), np.array([8.0, 0.0]))
        again = node.advance(window(0, 2), np.array([4.0, 0.0]))
        self.assertEqual(first.tolist(), again.tolist())
        self.assertNotEqual(first.tolist(), other.tolist())
        # du = sum of h (v0 + k h F / m), k = 1..4.
        self.assertEqual(first[0], 0.5 * 4 * 1.0 + 0.25 * 10 * 2.0)
        report = node.commit(window(0, 2), np.empty(0))
        self.assertEqual(report[0], 4.0 * first[0])

    def test_a_window_that_was_not_asked_for_is_not_committed(self):
        node = ready(Mass)
        node.advance(window(), np.zeros(2))
        with self.assertRaises(thirdbody.ProtocolError):
            node.commit(window(1), np.empty(0))

    def test_a_step_that_spoils_its_state_is_caught(self):
        node = ready(Mass)
        node.careless = True
        with self.assertRaisesRegex(ValueError, "read-only"):
            node.advance(window(), np.zeros(2))

    def test_columns_exclude_motion_without_a_force(self):
        node = ready(Mass)
        columns = node.columns(window())
        self.assertEqual(columns.tolist(), [[0.25 * 10 / 2.0, 0.0], [0.0, 0.25 * 10 / 2.0]])

    def test_a_checkpoint_gives_back_every_bit(self):
        node = ready(Mass)
        node.advance(window(), np.array([0.1, -0.3]))
        node.commit(window(), np.empty(0))
        saved = node.checkpoint()
        other = ready(Mass)
        other.restore(saved)
        force = np.array([0.7, 0.2])
        self.assertEqual(node.advance(window(1), force).tolist(), other.advance(window(1), force).tolist())
        self.assertEqual(node.commit(window(1), np.empty(0)), other.commit(window(1), np.empty(0)))
        self.assertEqual(node.finish().state_hash, other.finish().state_hash)

    def test_the_error_names_a_result_of_the_wrong_shape_or_without_value(self):
        node = ready(Mass)
        node.displacement = lambda state: np.zeros(2)
        with self.assertRaisesRegex(ConfigurationError, r"displacement\(\) has the shape"):
            node.advance(window(), np.zeros(2))
        node.displacement = lambda state: np.full((1, 2), 1.0 + 1.0j)
        with self.assertRaisesRegex(ConfigurationError, r"displacement\(\) holds complex numbers"):
            node.advance(window(), np.zeros(2))
        node.displacement = lambda state: np.full((1, 2), np.nan)
        with self.assertRaisesRegex(Diverged, "nan"):
            node.advance(window(), np.zeros(2))


class Slab(Mass):
    """Two points on the first of three layers of 2, 3 and 5 J/K, 0.5 W/K between neighbours, backward Euler; insulated."""

    start_k = 300.0
    capacity = np.array([2.0, 3.0, 5.0])
    heated = np.array([0, 0])
    conduction = 0.5 * np.array([[1.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])

    def points(self, set_name):
        return Points([0.0, 1.0], [0.0, 0.0])

    def rest(self):
        return {"u": np.zeros((2, 2)), "v": np.zeros((2, 2))}

    def warm(self, rise, heat, time_s):
        return np.linalg.solve(np.diag(self.capacity) + time_s * self.conduction, self.capacity * rise + heat)


class Warmth(unittest.TestCase):
    def go(self, node, *indices):
        for index in indices:
            node.advance(window(index), np.zeros(4))
            node.advance(window(index, 1), np.ones(4))
            node.commit(window(index, 1), np.empty(0))

    def take(self, node, *joules):
        return node.take_heat(window(), np.array(joules, dtype=float)).tolist()

    def test_a_body_without_temperatures_offers_and_takes_no_heat(self):
        self.assertNotIn("heat", ready(Mass).describe().capabilities)
        self.assertIs(ready(Slab).describe().capabilities["heat"], True)
        with self.assertRaisesRegex(ConfigurationError, "heat through its surface"):
            ready(Mass).take_heat(window(), np.zeros(1))
        with self.assertRaisesRegex(thirdbody.ProtocolError, "heat of 1 points arrived for 2"):
            ready(Slab).take_heat(window(), np.zeros(1))

    def test_heat_enters_over_the_time_since_the_last_exchange(self):
        node = ready(Slab)
        self.assertEqual(self.take(node, 0.0, 0.0), [300.0, 300.0])
        self.go(node, 0, 1)
        # Repeats take no time: two windows of 2 s.
        exact = node.warm(np.zeros(3), np.array([7.0, 0.0, 0.0]), 4.0)
        self.assertEqual(self.take(node, 3.0, 4.0), [300.0 + exact[0]] * 2)
        self.go(node, 2)
        self.assertEqual(self.take(node, 0.0, -1.0)[0], 300.0 + node.warm(exact, np.array([-1.0, 0.0, 0.0]), 2.0)[0])
        found = node.finish().results
        self.assertEqual((found["heat_interface_j"], found["surface_temperature_peak_k"]), (6.0, 300.0 + exact[0]))
        self.assertAlmostEqual(found["heat_stored_j"], 6.0, delta=1e-14)
        self.assertLess(found["heat_balance_rel"], 1e-15)

    def test_two_requests_at_one_time_are_one_with_the_sum(self):
        # Before the first window, between two windows, and after the last.
        parts, whole = ready(Slab), ready(Slab)
        for index in range(3):
            self.take(parts, 1.0, 0.0)
            self.assertEqual(self.take(parts, 0.5, 2.0), self.take(whole, 1.5, 2.0))
            self.go(parts, index)
            self.go(whole, index)
        self.take(parts, 1.0, 1.0)
        self.assertEqual(self.take(parts, 0.0, 0.0), self.take(whole, 1.0, 1.0))
        self.assertEqual(parts.finish().state_hash, whole.finish().state_hash)
        self.assertAlmostEqual(whole.finish().results["heat_stored_j"], 12.5, delta=1e-13)

    def test_heat_that_waits_for_the_first_window_is_stored(self):
        node = ready(Slab)
        self.take(node, 1.0, 2.0)
        self.assertEqual(node.finish().results["heat_stored_j"], 3.0)

    def test_a_window_after_a_return_to_a_checkpoint_takes_its_heat_once(self):
        # Checkpoints right after an exchange, and in the time between two.
        for before in ((), (1,)):
            node, other = ready(Slab), ready(Slab)
            self.go(node, 0)
            self.take(node, 1.0, 2.0)
            self.go(node, *before)
            saved = node.checkpoint()
            self.go(node, 2)
            first = self.take(node, 5.0, 0.0)
            once = node.finish()
            node.restore(saved)
            other.restore(saved)
            for again in (node, other):
                self.go(again, 2)
                self.assertEqual(self.take(again, 5.0, 0.0), first)
                self.assertEqual((again.finish().state_hash, again.finish().results), (once.state_hash, once.results))
            self.assertEqual(once.results["heat_interface_j"], 8.0)

    def test_points_that_are_not_selected_take_no_heat(self):
        node = ready(Slab)
        node.heated = np.array([2, 0])
        node.select(np.array([1]))
        node.advance(window(), np.zeros(2))
        node.commit(window(), np.empty(0))
        (kelvins,) = self.take(node, 3.0)
        self.assertEqual(kelvins, 300.0 + node.warm(np.zeros(3), np.array([3.0, 0.0, 0.0]), 2.0)[0])

    def test_a_temperature_that_is_not_finite_is_caught(self):
        node = ready(Slab)
        node.warm = lambda rise, heat, time_s: np.array([0.0, np.nan, 0.0])
        self.go(node, 0)
        with self.assertRaisesRegex(Diverged, "nan"):
            self.take(node, 1.0, 1.0)


class Springs(thirdbody.GrainLayer):
    """Two points on springs to the ground, F = -k u at the end of a window."""

    stiffness = np.array([[3.0, 1.0], [2.0, 5.0]])

    def points(self, set_name):
        return Points([0.0, 1.0], [0.0, 0.0])

    def rest(self):
        return np.zeros((2, 2))

    def step(self, state, velocity, window_s):
        state = state + window_s * velocity
        return state, -self.stiffness * state


class Layers(unittest.TestCase):
    def test_a_compliant_boundary_moves_as_its_equation_says(self):
        node = ready(Springs)
        half = np.random.default_rng(5).normal(size=(4, 4))
        compliance = half @ half.T
        node.set_boundary(2.0, compliance.reshape(-1, order="F"))
        free = np.array([1.0, -2.0, 0.5, 0.25])
        for index in range(3):
            force, velocity, repeats, residual, converged = node.solve(window(index), free)
            # v = a + 2 W F, F = -k (u + 2 v).
            u = node.state.reshape(-1)
            k = Springs.stiffness.reshape(-1)
            exact = np.linalg.solve(np.eye(4) + 4.0 * compliance * k, free - 2.0 * compliance @ (k * u))
            self.assertTrue(converged)
            self.assertLess(np.abs(velocity - exact).max(), 1e-7 * np.abs(free).max())
            self.assertLess(np.abs(velocity - free - 2.0 * compliance @ force).max(), 1e-8)
            again = node.solve(window(index, 1), free)
            self.assertEqual((again[0].tolist(), again[1].tolist()), (force.tolist(), velocity.tolist()), "repeats leave nothing behind")
            node.commit(window(index, 1), np.empty(0))
        self.assertLess(repeats, 10)

    def test_a_rigid_boundary_is_taken_as_it_comes(self):
        node = ready(Springs)
        node.set_boundary(2.0, np.zeros(16))
        free = np.arange(4.0)
        force, velocity, *_ = node.solve(window(), free)
        self.assertEqual(velocity.tolist(), free.tolist())
        self.assertEqual(force.tolist(), (-Springs.stiffness.reshape(-1) * 2.0 * free).tolist())

    def test_a_layer_for_rigid_boundaries_refuses_others(self):
        node = ready(Springs)
        node.compliant = False
        node.set_boundary(2.0, np.zeros(16))
        with self.assertRaisesRegex(ConfigurationError, "rigid boundary"):
            node.set_boundary(2.0, np.eye(4).reshape(-1))


class Edges(unittest.TestCase):
    X = np.array([0.0, 1.0, 2.0, 3.5, 5.0])

    def test_a_uniform_traction_gives_the_consistent_forces_of_quadratic_edges(self):
        # On straight lines each node takes half of the neighbouring lengths, on a quadratic edge the shares are 1/6 : 2/3 : 1/6.
        straight = np.array([0.5, 1.0, 1.25, 1.5, 0.75])
        force = thirdbody.traction_matrix(self.X, 2).T @ straight
        np.testing.assert_allclose(force, np.array([2.0, 8.0, 5.0, 12.0, 3.0]) / 6.0, rtol=1e-13)

    def test_edges_of_first_order_are_the_straight_lines(self):
        np.testing.assert_allclose(thirdbody.traction_matrix(self.X, 1), np.eye(5), atol=1e-14)

    def test_any_order_keeps_force_and_moment(self):
        for order in (1, 2, 4):
            force = np.array([3.0, -1.0, 4.0, 1.0, -5.0])
            given = thirdbody.traction_matrix(self.X, order).T @ force
            np.testing.assert_allclose([given.sum(), self.X @ given], [force.sum(), self.X @ force], rtol=1e-12)

    def test_nodes_between_corners_lie_on_the_crown_as_corners_do(self):
        keys = {
            "size_m": 0.8e-3, "fine_width_m": 3.2e-3, "fine_depth_m": 1.6e-3, "width_m": 12e-3, "height_m": 6e-3,
            "side_columns": 3, "depth_rows": 2, "crown_radius_m": 0.3,
        }
        corner_x, corner_y, quads = thirdbody.crowned_grid(Config(keys))
        for order in (2, 4):
            x, y, theirs = thirdbody.crowned_grid(Config(keys), order)
            np.testing.assert_array_equal(x[::order, ::order], corner_x)
            np.testing.assert_array_equal(y[::order, ::order], corner_y)
            np.testing.assert_array_equal(x.reshape(-1)[theirs], corner_x.reshape(-1)[quads])
            np.testing.assert_array_equal(y.reshape(-1)[theirs], corner_y.reshape(-1)[quads])
            np.testing.assert_allclose(np.hypot(x[-1], y[-1] + 0.3), 0.3, rtol=1e-14)
            # Inner nodes of fourth order: (1 -+ sqrt(3/7)) / 2 of a cell, and its middle.
            within = np.array([0.5 - 0.5 * np.sqrt(3.0 / 7.0), 0.5, 0.5 + 0.5 * np.sqrt(3.0 / 7.0)])[{2: [1], 4: [0, 1, 2]}[order]]
            for along in (x[0], y[:, x.shape[1] // 2]):
                corners = along[::order]
                np.testing.assert_allclose(along[1:order], corners[0] + within * (corners[1] - corners[0]), rtol=1e-12)


class Configurations(unittest.TestCase):
    def test_a_key_that_nothing_reads_is_refused(self):
        config = Config({"stiffness_pa": 1.0, "mesh": {"size_m": 1.0, "sizes": 2}})
        config.number("stiffness_pa", above=0)
        config.table("mesh").number("size_m")
        with self.assertRaisesRegex(ConfigurationError, r"config.mesh.sizes: no such key; did you mean `size_m`"):
            config.require_all_read()
        with self.assertRaisesRegex(ConfigurationError, "damping_ratio is missing; does `dampin_ratio` stand for it"):
            Config({"dampin_ratio": 0.1}).number("damping_ratio")

    def test_values_are_checked_where_they_are_read(self):
        config = Config({"a": "x", "b": -1.0, "c": float("nan"), "d": 1.5, "e": True})
        for key in "ace":
            with self.assertRaisesRegex(ConfigurationError, f"config.{key}"):
                config.number(key)
        with self.assertRaisesRegex(ConfigurationError, "above 0"):
            config.number("b", above=0)
        with self.assertRaisesRegex(ConfigurationError, "whole"):
            config.integer("d")
        with self.assertRaisesRegex(ConfigurationError, "missing"):
            config.number("f")
        self.assertEqual(config.number("f", 3), 3.0)


class States(unittest.TestCase):
    STATE = {
        "u": np.arange(6.0).reshape(3, 2), "n": -7, "big": 2**80, "t": (1.5, None, True, "naïve"), "l": [b"\x00\xff", {}],
        "i": np.array([1, 2], dtype=np.int32), "b": np.array([True, False]), "empty": np.empty((0, 2)),
    }

    def test_a_state_survives_as_bytes(self):
        read = from_bytes(to_bytes(self.STATE))
        self.assertEqual(to_bytes(read), to_bytes(self.STATE))
        self.assertEqual(read["t"], self.STATE["t"])
        self.assertEqual(read["big"], 2**80)
        self.assertEqual(read["u"].dtype, np.float64)
        self.assertEqual(read["empty"].shape, (0, 2))

    def test_another_bit_is_another_hash(self):
        other = {**self.STATE, "u": self.STATE["u"].copy()}
        self.assertEqual(digest(other), digest(self.STATE))
        other["u"][2, 1] = np.nextafter(5.0, 6.0)
        self.assertNotEqual(digest(other), digest(self.STATE))

    def test_damage_and_values_that_are_not_data_are_refused(self):
        data = to_bytes(self.STATE)
        for cut in range(len(data)):
            with self.assertRaises(ConfigurationError):
                from_bytes(data[:cut])
        with self.assertRaisesRegex(ConfigurationError, "too long"):
            from_bytes(data + b"n")
        with self.assertRaisesRegex(ConfigurationError, r"state.a\[1\] is a set"):
            to_bytes({"a": [1, {2}]})


def has_scipy():
    try:
        import scipy  # noqa: F401
    except ImportError:
        return False
    return True


class Chain(thirdbody.Modal):
    """Eight masses of 2 kg between springs of 3 N/m, the first spring held; the last two masses are a point with two components."""

    modes = 3

    def __init__(self, config, setting):
        super().__init__(config, setting)
        from scipy.sparse import diags

        main = np.full(8, 6.0)
        main[-1] = 3.0
        self.stiffness = diags([main, np.full(7, -3.0), np.full(7, -3.0)], [0, 1, -1])
        self.mass = np.full(8, 2.0)
        self.x, self.y, self.coupled = np.zeros(1), np.zeros(1), np.array([6, 7])

    def points(self, set_name):
        return Points(self.x, self.y, length_m=1.0)


@unittest.skipUnless(has_scipy(), "needs SciPy")
class Modes(unittest.TestCase):
    def test_a_constant_force_swings_about_the_equilibrium(self):
        node = ready(Chain)
        force = np.array([0.5, -2.0])
        moved = [np.zeros(2)]
        for index in range(4000):
            moved.append(moved[-1] + node.advance(window(index), force))
            node.commit(window(index), np.empty(0))
        stiff = node.stiffness.toarray()
        exact = np.linalg.inv(stiff)[np.ix_([6, 7], [6, 7])] @ force
        self.assertLess(abs(np.mean(moved, axis=0) - exact).max(), 2e-2 * abs(exact).max())

    def test_a_window_is_affine_with_the_columns_as_slope_and_keeps_its_energy(self):
        for modes in (3, 8):
            Chain.modes = modes
            node = ready(Chain)
            for index in range(50):
                force = np.array([np.sin(3.0 * index), np.cos(5.0 * index)])
                free, whole = (node.advance(window(index), f) for f in (np.zeros(2), force))
                error = whole - free - node.columns(window(index)) @ force
                self.assertLess(abs(error).max(), 1e-12)
                work, strain, kinetic, lost = node.commit(window(index), np.empty(0))
            self.assertLess(abs(work - strain - kinetic - lost), 1e-10 * (abs(work) + strain))
            self.assertLess(lost, 1e-12 if modes == 8 else work)
        Chain.modes = 3

    def test_all_modes_move_like_the_masses(self):
        Chain.modes = 8
        node = ready(Chain)
        Chain.modes = 3
        u, v, h, force = np.zeros(8), np.zeros(8), 1e-3, np.zeros(8)
        force[6:] = [0.5, -2.0]
        node.advance(window(), force[6:])
        stiff = node.stiffness.toarray()
        for _ in range(round(window().length_s / h)):
            v = v + 0.5 * h * (force - stiff @ u) / 2.0
            u = u + h * v
            v = v + 0.5 * h * (force - stiff @ u) / 2.0
        self.assertLess(abs(node.advance(window(), force[6:]) - u[6:]).max(), 1e-6)


if __name__ == "__main__":
    unittest.main()
