# Public names of `roughxr.archive`, which `lazy_loader` imports on first use.

from .application.archive import load as load
from .application.archive import save as save
