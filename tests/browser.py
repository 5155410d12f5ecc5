"""The system's Chromium, headless, for tests of pages: window sizes, clicks and keys."""

from __future__ import annotations

import shutil
from pathlib import Path

from selenium import webdriver
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

BROWSER = shutil.which("chromium") or shutil.which("google-chrome")

#: Why a test that needs the browser is skipped.
NO_BROWSER = "no Chromium to open the page with"

_OPTIONS = (
    "--headless=new",
    "--no-sandbox",
    "--disable-gpu",
    "--hide-scrollbars",
    "--host-resolver-rules=MAP * ~NOTFOUND",
)


class Browser:
    """One tab; a context manager that ends the browser."""

    def __init__(self):
        options = webdriver.ChromeOptions()
        options.binary_location = BROWSER
        for option in _OPTIONS:
            options.add_argument(option)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        self.driver = webdriver.Chrome(options, webdriver.ChromeService(shutil.which("chromedriver")))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.driver.quit()

    def open(self, path: Path, width: int, height: int = 900, address: str = ""):
        """Open a file in a window of so many pixels."""
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
        self.driver.get("about:blank")  # another part of the same page would not be loaded again
        self.driver.get_log("browser")
        self.driver.get(path.resolve().as_uri() + address)

    def value(self, expression: str):
        """Return the value of a script's expression."""
        return self.driver.execute_script(f"return {expression}")

    def click(self, selector: str):
        """Click in the middle of an element."""
        element = self.driver.find_element(By.CSS_SELECTOR, selector)
        self.driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", element)
        webdriver.ActionChains(self.driver).move_to_element(element).click().perform()

    def press(self, key: str):
        """Press a key such as RIGHT or TAB."""
        webdriver.ActionChains(self.driver).send_keys(getattr(Keys, key)).perform()

    def complaints(self) -> list[str]:
        """Return the errors in the console since the page was opened, and its requests to the network."""
        errors = [entry["message"] for entry in self.driver.get_log("browser") if entry["level"] == "SEVERE"]
        requested = self.value("performance.getEntriesByType('resource').map(entry => entry.name)")
        return errors + [url for url in requested if not url.startswith(("file:", "data:", "blob:"))]

    def picture(self, path: Path):
        """Write the whole page as a PNG file."""
        self.driver.set_window_size(self.value("innerWidth"), self.value("document.documentElement.scrollHeight"))
        self.driver.save_screenshot(str(path))
