"""A rail as a bed of independent springs (Winkler 1867)."""

import numpy as np
import thirdbody


class Winkler(thirdbody.Continuum):
    kind = "winkler"
    outward = {"top": (0.0, 1.0)}

    def __init__(self, config, setting):
        super().__init__(config, setting)
        self.step_s = config.number("step_s", above=0)
        spacing, width = config.number("spacing_m", above=0), config.number("width_m", above=0)
        crown = config.number("crown_radius_m", above=0)
        n = int(round(width / spacing))
        self.x = spacing * (np.arange(n + 1) - 0.5 * n)
        self.y = np.sqrt(crown**2 - self.x**2) - crown
        self.stiffness = config.number("stiffness_pa_per_m", above=0) * spacing * setting.thickness_m
        self.mass = config.number("mass_kg_per_m2", above=0) * spacing * setting.thickness_m

    def points(self, set_name):
        return thirdbody.Points(self.x, self.y, mass_kg=self.mass)

    def rest(self):
        return np.zeros((self.x.size, 2))

    def step(self, state, force, n):
        return force / self.stiffness

    def displacement(self, state):
        return state

    def energy(self, state):
        return {"stored": {"springs": 0.5 * self.stiffness * float((state**2).sum())}}


thirdbody.participate(Winkler)
