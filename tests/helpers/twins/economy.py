"""MARECO once more, as OSRD writes it down: an explicit simulation in short steps of distance, of a plain train.

One effort curve, one braking rate, Davis resistance and gradients at the head. No row, curve or kernel of tgvdp.
"""

import numpy as np

STEP_M = 2.0


class Twin:
    """A train on a section from stop to stop, as arrays over positions every STEP_M.

    Parameters
    ----------
    mass_kg, inertia_kg, davis, effort_n, rate_mps2
        The train: (A, B, C) of its resistance, its largest effort by speed, and its braking.
    grade_permil, limit_mps : callable
        By position, m.
    """

    def __init__(self, length_m, mass_kg, inertia_kg, davis, effort_n, rate_mps2, grade_permil, limit_mps):
        self.x_m = np.arange(0.0, length_m + 0.5 * STEP_M, STEP_M)
        middle_m = self.x_m[:-1] + 0.5 * STEP_M
        self.slope_n = np.array([mass_kg * 9.81 * grade_permil(x) / 1000.0 for x in middle_m])
        self.limit_w = np.array([limit_mps(x) ** 2 for x in middle_m])
        self.inertia_kg, self.davis, self.effort_n, self.rate_mps2 = inertia_kg, davis, effort_n, rate_mps2

    def resistance_n(self, v):
        a, b, c = self.davis
        return a + b * v + c * v * v

    def ends_mps(self, v1):
        """vf of v1."""
        hold_w = v1 * v1 * (self.davis[1] + 2.0 * self.davis[2] * v1)
        return hold_w * v1 / (hold_w + self.resistance_n(v1) * v1)

    def coasting_mps2(self, k, v):
        return -(self.resistance_n(v) + self.slope_n[k]) / self.inertia_kg

    def capped(self, v1):
        """v² of the fastest run under a cap, and where it brakes."""
        count = len(self.x_m)
        limit_w = np.minimum(self.limit_w, v1 * v1)
        braked_w = np.zeros(count)
        for k in range(count - 2, -1, -1):
            braked_w[k] = min(braked_w[k + 1] + 2.0 * self.rate_mps2 * STEP_M, limit_w[k], limit_w[max(k - 1, 0)])
        w = np.zeros(count)
        for k in range(count - 1):
            v = np.sqrt(w[k])
            gain = 2.0 * (self.effort_n(v) / self.inertia_kg + self.coasting_mps2(k, v)) * STEP_M
            w[k + 1] = min(w[k] + gain, limit_w[k], braked_w[k + 1])
        return w

    def coasted(self, base_w, end, least_w):
        """v² with coasting that ends at a station and is no slower than least, and where it begins."""
        w, k, held = base_w[end], end, False
        while k > 0:
            w -= 2.0 * self.coasting_mps2(k - 1, np.sqrt(w)) * STEP_M
            held |= w < least_w
            w = max(w, least_w)
            k -= 1
            if w >= base_w[k]:
                break
        run_w, w, begin = base_w.copy(), base_w[k], k
        while k < len(base_w) - 1:
            w += 2.0 * self.coasting_mps2(k, np.sqrt(w)) * STEP_M
            k += 1
            if w >= base_w[k]:
                return run_w, begin
            run_w[k] = max(w, 0.0)
        return base_w, end

    def run(self, v1):
        """v² of the economy run with a cap."""
        base_w, vf = self.capped(v1), self.ends_mps(v1)
        run_w, begin = base_w.copy(), len(base_w)
        for end, least_w in sorted(self._opportunities(base_w, v1, vf), reverse=True):
            if end <= begin:
                own_w, begin = self.coasted(base_w, end, least_w)
                run_w[begin : end + 1] = np.minimum(own_w, run_w)[begin : end + 1]
        return run_w

    def _opportunities(self, base_w, v1, vf):
        falls = np.diff(base_w) < -1.9 * self.rate_mps2 * STEP_M
        for k in range(len(falls)):
            if falls[k] and (k + 1 == len(falls) or not falls[k + 1]) and base_w[k + 1] > vf * vf:
                yield k + 1, vf * vf
            if falls[k] and base_w[k] > vf * vf >= base_w[k + 1]:
                yield k, vf * vf
        level = np.abs(np.diff(base_w)) < 1e-9
        pulled = [bool(flat) and self.coasting_mps2(k, np.sqrt(base_w[k])) > 0.0 for k, flat in enumerate(level)]
        k = 0
        while k < len(pulled):
            first = k
            while k < len(pulled) and pulled[k]:
                k += 1
            if k > first and base_w[first] > vf * vf:
                v = np.sqrt(base_w[first])
                a = np.mean([self.coasting_mps2(i, v) for i in range(first, k)])
                b = min(self.coasting_mps2(max(first - 1, 0), v), 0.0)
                hold_w = v1 * v1 * (self.davis[1] + 2.0 * self.davis[2] * v1)
                yield k, max(1.0 / (1.0 / v + self.resistance_n(v) / (hold_w * (1.0 - b / a))), vf) ** 2
            k += 1

    def figures(self, w):
        """Running time, s, and traction work, J."""
        v = np.sqrt(w)
        force_n = 0.5 * self.inertia_kg * np.diff(w) / STEP_M + self.slope_n + self.resistance_n(0.5 * (v[1:] + v[:-1]))
        return float(np.sum(2.0 * STEP_M / (v[1:] + v[:-1]))), float(np.sum(np.maximum(force_n, 0.0)) * STEP_M)

    def of_time(self, time_s):
        """Running time and work of the cap that takes a time."""
        low, high = 2.0, 200.0
        for _ in range(24):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self.figures(self.run(middle))[0] > time_s else (low, middle)
        return self.figures(self.run(high))
