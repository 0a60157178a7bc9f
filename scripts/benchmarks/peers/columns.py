#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""frozen-ground-fem on the problems of scripts/accuracy: thaw from a wall (Neumann) and consolidation (Terzaghi), error and processor time.

usage  PYTHONPATH=<clone>/src columns.py <rows.json>

The same heights, instants and norms as in scripts/talik/studies/accuracy. Its conductivity is a geometric mean and its ice has another
density, so Neumann's front is computed for the ground that it has. Consolidation of small strain: a load of 0.1 % of the stress."""

import json
import math
import sys
import time

import numpy as np
from frozen_ground_fem import ConsolidationAnalysis1D, ConsolidationBoundary1D, HydraulicBoundary1D, Material, ThermalAnalysis1D, ThermalBoundary1D
from frozen_ground_fem.materials import dens_water, latent_heat_fusion_water, spec_grav_ice, unit_weight_water
from frozen_ground_fem.materials import thrm_cond_ice, thrm_cond_water, vol_heat_cap_ice, vol_heat_cap_water
from scipy.optimize import brentq

porosity = 0.4
voidRatio = porosity / (1 - porosity)


def column(kind, depth, elements, material):
	analysis = kind(z_range=[0.0, depth], num_elements=elements, order=1, generate=True)
	for element in analysis.elements:
		element.assign_material(material)
		for point in element.int_pts:
			point.void_ratio = point.void_ratio_0 = voidRatio
	for node in analysis.nodes:
		node.void_ratio = node.void_ratio_0 = voidRatio
	return analysis


def thaw(cells, tolerance, front=0.2, surface=10.0, initial=-5.0):
	soil = Material(thrm_cond_solids=1.0, spec_grav_solids=2.65, spec_heat_cap_solids=800.0)
	analysis = column(ThermalAnalysis1D, 10 * front, 10 * cells, soil)
	analysis.implicit_error_tolerance = tolerance
	for node in analysis.nodes:
		node.temp = initial
	for end, temperature in ((0, surface), (-1, initial)):
		wall = ThermalBoundary1D((analysis.nodes[end],), (analysis.elements[end].int_pts[end],))
		wall.bnd_type, wall.bnd_value = ThermalBoundary1D.BoundaryType.temp, temperature
		analysis.add_boundary(wall)
	analysis.time_step = 0.001
	analysis.initialize_global_system(t0=0.0)
	solid = (1 - porosity) * soil.vol_heat_cap_solids
	thawed = thrm_cond_water**porosity, solid + porosity * vol_heat_cap_water  # conductivity [W/(m K)], heat capacity [J/(m3 K)]
	frozen = thrm_cond_ice**porosity, solid + porosity * vol_heat_cap_ice
	latent = porosity * latent_heat_fusion_water * spec_grav_ice * dens_water
	rate = neumann(thawed, frozen, latent, surface, initial)
	answer, start = [], time.process_time()
	for instant in np.linspace(0.5, 1, 40) * (front / rate) ** 2:
		analysis.solve_to(instant)
		temperature, depth = np.array([node.temp for node in analysis.nodes]), np.array([node.z for node in analysis.nodes])
		k = int(np.argmax(temperature < 0))
		zero = np.interp(0.0, temperature[[k, k - 1]], depth[[k, k - 1]])
		answer.append(zero / (rate * math.sqrt(instant)))
	return float(np.sqrt(np.mean((np.array(answer) - 1) ** 2))), time.process_time() - start


def neumann(thawed, frozen, latent, surface, initial):
	"""X/sqrt(t) [m/s^0.5]."""
	(k, c), (kf, cf) = thawed, frozen

	def missing(x):
		a, b = x / 2 * math.sqrt(c / k), x / 2 * math.sqrt(cf / kf)
		return (
			k * surface * math.exp(-a * a) / (math.sqrt(math.pi * k / c) * math.erf(a))
			+ kf * initial * math.exp(-b * b) / (math.sqrt(math.pi * kf / cf) * math.erfc(b))
			- latent * x / 2
		)

	return brentq(missing, 1e-8, 20 * math.sqrt(kf / cf))


def consolidate(cells, tolerance, height=1.0, stress=1e5, load=1e2, conductivity=1e-6):
	compression = 1.0
	soil = Material(
		spec_grav_solids=1.0,  # no weight under water
		hyd_cond_index=1e3,
		hyd_cond_0=conductivity,
		void_ratio_0_hyd_cond=voidRatio,
		void_ratio_0_comp=voidRatio,
		comp_index_unfrozen=compression,
		rebound_index_unfrozen=compression,
		eff_stress_0_comp=stress,
		void_ratio_tr=voidRatio,
		void_ratio_sep=voidRatio,
		void_ratio_lim=0.01,
		void_ratio_min=0.01,
	)
	analysis = column(ConsolidationAnalysis1D, height, cells, soil)
	analysis.implicit_error_tolerance = tolerance
	kinds = ConsolidationBoundary1D.BoundaryType, HydraulicBoundary1D.BoundaryType
	after = voidRatio - compression * math.log10(1 + load / stress)
	top = ConsolidationBoundary1D((analysis.nodes[0],), bnd_type=kinds[0].void_ratio, bnd_value=after, bnd_value_1=stress + load)
	analysis.add_boundary(top)
	analysis.add_boundary(HydraulicBoundary1D((analysis.nodes[0],), bnd_type=kinds[1].fixed_head, bnd_value=height))
	modulus = (1 + voidRatio) * stress * math.log(10) / compression
	rate = conductivity * modulus / unit_weight_water / height**2  # T_v in a second
	analysis.time_step = 1e-4 / rate
	analysis.initialize_global_system(t0=0.0)
	heights, answer, exact, start = (np.arange(8) + 0.5) / 8, [], [], time.process_time()
	for factor in (0.1, 0.2, 0.5, 0.8):
		analysis.solve_to(factor / rate)
		points = [point for element in analysis.elements for point in element.int_pts]
		above = height - np.array([point.z for point in points])
		order = np.argsort(above)
		pressure = np.array([point.exc_pore_pressure for point in points]) / load
		answer += list(np.interp(heights, np.append(above[order], height), np.append(pressure[order], 0.0)))
		odd = 2 * np.arange(400) + 1
		exact += list(
			4
			/ math.pi
			* ((-1.0) ** np.arange(400) / odd * np.exp(-(odd**2) * math.pi**2 * factor / 4) * np.cos(np.outer(heights, odd) * math.pi / 2)).sum(axis=1)
		)
	return float(np.sqrt(np.mean((np.array(answer) - exact) ** 2))), time.process_time() - start


def main(file):
	rows = []
	for problem, run, cases in (
		("Terzaghi", consolidate, ((5, 1e-6), (10, 1e-6), (20, 1e-6), (40, 1e-6))),
		("Neumann thaw", thaw, ((4, 1e-4),)),
	):
		for cells, tolerance in cases:
			error, seconds = run(cells, tolerance)
			rows.append(
				{
					"problem": problem,
					"code": "frozen-ground-fem",
					"settings": f"{cells} elements, tolerance {tolerance:g}, default freezing curve"
					if run is thaw
					else f"{cells} elements, tolerance {tolerance:g}",
					"error": error,
					"seconds": seconds,
				}
			)
			print(rows[-1], flush=True)
	with open(file, "w", encoding="utf-8") as out:
		json.dump(rows, out, indent="\t")


if __name__ == "__main__":
	main(*sys.argv[1:])
