# Public names of `roughxr.report`, which `lazy_loader` imports on first use.

from .application.report.caveats import cautions as cautions
from .application.report.explorer import write_explorer as write_explorer
from .application.report.report_page import write_report as write_report
from .application.report.summary import headline as headline
