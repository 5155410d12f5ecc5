# Public names of `roughxr.scans`, which `lazy_loader` imports on first use.

from .application.samples import open_sample as open_sample
from .files.images.backend import RoughxrBackend as RoughxrBackend
from .files.images.backend import open_scan as open_scan
from .files.images.channel import UnreadableScan as UnreadableScan
from .files.images.container import open_container as open_container
from .files.images.description import describe as describe
from .files.images.export import to_file as to_file
from .files.images.export import to_netcdf as to_netcdf
from .mechanics.scans import regions as regions
from .mechanics.scans import synthetic as synthetic
from .mechanics.scans.combined_spectra import combined_spectrum as combined_spectrum
from .mechanics.scans.editing import crop as crop
from .mechanics.scans.editing import fill as fill
from .mechanics.scans.editing import resample as resample
from .mechanics.scans.fine_scales import self_affine_fit as self_affine_fit
from .mechanics.scans.fine_scales import smooth as smooth
from .mechanics.scans.levelling import level as level
from .mechanics.scans.plausibility import ImplausibleScan as ImplausibleScan
from .mechanics.scans.roughness_parameters import roughness as roughness
from .mechanics.scans.spectra import power_spectrum as power_spectrum
from .mechanics.scans.tip import dilate as dilate
from .mechanics.scans.tip import erode as erode
from .mechanics.scans.tip import tip_flags as tip_flags
