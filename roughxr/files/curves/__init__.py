"""Measured pull-off forces in files, and what force-distance curves hold.

opening                              any file of measured forces, one or many
force_tables, vendor_scales, forces  tables; images of adhesion and their scales; units and signs of forces
curves, curve_files, curve_reader    recorded force-distance curves
segments                             approach and retraction of a curve
force_curves, baselines              pull-off forces from curves
sharp_steps, doubts                  the smallest pull that a curve would show; curves to look at
curve_fit                            modulus and work of adhesion, fitted to curves
"""
