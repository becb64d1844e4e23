"""A rail as a bed of independent springs with dashpots: put your own physics into `step`, `points` and `rest`."""

import numpy as np
import thirdbody


class Rail(thirdbody.Continuum):
    kind = "skeleton"
    software = "skeleton 0.1"
    sets = ("top",)
    outward = {"top": (0.0, 1.0)}

    def __init__(self, config, setting):
        """Reads the keys of `participant.<name>.config`; a key that nothing reads is an error."""
        super().__init__(config, setting)
        # Omit this in a solver without its own step; `interface.<name>.window_s` then gives the window length.
        self.step_s = config.number("step_s", above=0)
        self.relaxation_s = config.number("relaxation_s", above=0)
        spacing, width = config.number("spacing_m", above=0), config.number("width_m", above=0)
        crown = config.number("crown_radius_m", above=0)
        count = int(round(width / spacing)) + 1
        self.x = spacing * (np.arange(count) - 0.5 * (count - 1))
        self.y = np.sqrt(crown**2 - self.x**2) - crown
        self.stiffness = config.number("stiffness_pa_per_m", above=0) * spacing * setting.thickness_m
        self.mass = config.number("mass_kg_per_m2", above=0) * spacing * setting.thickness_m

    def points(self, set_name):
        """Positions (m) of the points of a set, with their masses (kg) for predictions of stability."""
        return thirdbody.Points(self.x, self.y, mass_kg=self.mass)

    def rest(self):
        """The initial state: numbers, texts, arrays, and lists and dictionaries of them."""
        return {"u": np.zeros((self.x.size, 2)), "dissipated_j": 0.0}

    def step(self, state, force, n):
        """The state `n` steps later under a constant force (N), rows of (x, y). Does not change the state it gets."""
        left = np.exp(-n * self.step_s / self.relaxation_s)
        away = state["u"] - force / self.stiffness
        dissipated = 0.5 * self.stiffness * float((away**2).sum()) * (1.0 - left**2)
        return {"u": force / self.stiffness + away * left, "dissipated_j": state["dissipated_j"] + dissipated}

    def displacement(self, state):
        """Displacement of each point since the start (m), rows of (x, y)."""
        return state["u"]

    def energy(self, state):
        """Energies since the start (J); the base class adds the interface work. Without this method there is no ledger."""
        stored = 0.5 * self.stiffness * float((state["u"] ** 2).sum())
        return {"stored": {"springs": stored}, "dissipated": {"dashpots": state["dissipated_j"]}}

    def results(self, state):
        """Results of the run, unit in the name."""
        return {"deepest_m": -float(state["u"].min())}


thirdbody.participate(Rail)
