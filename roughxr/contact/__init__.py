"""Contact of an indenter with a scan or its asperities: a labelled Dataset in, a labelled Dataset out.

A Dataset is read once into plain numbers, solved by one of the kinds of contact, and labelled once.

problem         specimen and options -> plain numbers, and the surface at each contact centre
solving         one problem solved at every centre
elastic         `direct`: the half space without adhesion, at displacements or loads
adhesion        `adhesive`: the half space with adhesion, through loading and retraction; its options are read by
                adhesive_options, one place is followed by cycle and recorded by adhesive_record
batch           pull-offs of slightly different surfaces, pairs and meshes, in one batch
rigid           `rigid`: bodies too stiff to deform
menisci         condensed liquid between them: its work, and the error of thin menisci
regimes         `regime`, `formulas`: the recommended model, and the usual formulas
estimates       `tabor`, and the pull-off from an elastic sweep: cheap estimates
reference       closed forms of single contacts, and formulas for rough ones, to compare with

A new kind of contact is one new file: a layout of what it returns, a function ``(place, problem, layout, options) ->
record``, and a public verb that reads its options and calls `solving.solve`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(__name__, submodules=["reference"])
