# SPDX-License-Identifier: GPL-2.0-or-later
"""Growth of frozen strength with the strain rate: tenfold in compression, hardly in tension (Haynes, Karalius & Kalafut 1975, abstract: -10 degC,
1.2e-4 to 2.9 1/s)."""

from yade import wrapper

from talik.studies import growth


def test_compression_grows_tenfold_with_the_rate_and_tension_hardly_where_moments_do_not_break_bonds_slow(sampleCache, monkeypatch):
	"""Bonds whose shear strength is 0.4 of the tensile one at the slow rate, in samples that roll with resistance; exponent of the bonds 0.3."""
	wanted = ("IceStrength's defaults", "shear 0.4 of tensile", "0.4, moments and rolling", "0.4, moments and rolling, n 0.3", "of the page")
	# what the help of IceStrength and the page tell to write, with the weak shear strength in the material
	page = growth.Kind(dict(bondRadiusFactor=2, momentContribution=0, etaRoll=0.2, iceShearStrength=20e6), 1.0, 0.3)
	monkeypatch.setitem(growth.kinds, "of the page", page)
	assert "iceShearStrength=20e6, etaRoll=0.2, bondRadiusFactor=2 and momentContribution=0" in wrapper.IceStrength.shearRateExponent.__doc__
	print()
	found = growth.table(100, 2, which=wanted, cache=sampleCache)
	plain, weakShear, carrying, steep, ofThePage = (found[name] for name in wanted)
	ratio = [(of.compression[1] / of.tension[1]).mean() for of in (plain, steep)]
	print(f"compression over tension at the fast rate: {ratio[0]:.1f} with the defaults, {ratio[1]:.1f} with moments and rolling")
	assert 1.2 < plain.ofCompression < weakShear.ofCompression < carrying.ofCompression
	assert carrying.ofCompression > 5 and 7.5 < steep.ofCompression < 13 and 7.5 < ofThePage.ofCompression < 13
	assert max(of.ofTension for of in found.values()) < 1.3


def test_the_command_writes_table_and_picture_slow(calibrateCommand):
	assert len(calibrateCommand("growth", "--grains", "40", "--realisations", "1")) == 2 + len(growth.kinds)
