"""Contact of an indenter with a scan or its asperities: a labelled Dataset in, a labelled Dataset out.

A Dataset is read once on the way down and made once on the way up; what differs between kinds of contact lies between.

problem         scan, pair and options -> plain numbers, and the surface at each contact centre
records         what a solver returns of one centre -> the labelled Dataset of all
elastic         `direct`: the half space without adhesion, at displacements or loads
adhesion        `adhesive`: the half space with adhesion, through loading and retraction
superposition   `superpose`: the sum of single asperities
maps            `pull_off_map`: the exact pull-off of that sum, up to every pixel
rigid_bodies    `rigid`: bodies too stiff to bend, the pull of all that faces the indenter, up to every pixel
regimes         `regime`, `formulas`: which model suits, what the usual formulas make of it
short_waves     `scale_dependence`: what waves shorter than the scan shows would do
estimates       `elastic_pull_off`, `tabor`: what costs next to nothing
reference       closed forms of single contacts, and formulas for rough ones, to hold results against

A new kind of contact is one new file: a layout of what it returns, a function ``(place, problem, layout, options) ->
record``, and a public verb that reads its options and calls `records.solve`.
"""
