"""Contact of an indenter with a scan at every place: elastic, adhesive or rigid; closed forms.

A Dataset is read once into plain numbers, solved by one of the kinds of contact, and labelled once.

problem         specimen and options as plain numbers, and the surface at each contact centre
solving         one problem solved at every centre
elastic         `direct`: the half space without adhesion, at displacements or loads
adhesion        `adhesive`: the half space with adhesion, through loading and retraction; adhesive_options reads its
                options, cycle follows one place, adhesive_record writes its record
batch           pull-offs of slightly different surfaces, pairs and meshes, in one batch
rigid           `rigid`: bodies too stiff to deform
menisci         condensed liquid between rigid bodies: its work, and the error of thin menisci
regimes         `regime`, `formulas`: the recommended model, and the usual formulas
estimates       `tabor`: Tabor's parameter, and the law that follows from it
reference       closed forms of single contacts, and formulas for rough surfaces, for comparison

A new kind of contact is one new file: the layout of its results, a function ``(place, problem, layout, options) ->
record``, and a public verb that reads its options and calls `solving.solve`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(__name__, submodules=["reference"])
