"""Contact of an indenter with a scan or its asperities: a labelled Dataset in, a labelled Dataset out."""
