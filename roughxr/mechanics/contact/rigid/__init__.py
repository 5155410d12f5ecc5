"""`rigid`: bodies too stiff to deform."""
