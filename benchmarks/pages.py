"""Pages in Chromium without a window, for benchmarks: how soon one is drawn."""

import os
import re
import shutil
import time

MARK = "performance.getEntriesByName('skpose: first frame drawn')[0]?.startTime"


def browser():
    from selenium.webdriver import Chrome, ChromeOptions, ChromeService

    options = ChromeOptions()
    options.binary_location = shutil.which("chromium") or shutil.which("google-chrome")
    root = ["--no-sandbox"] if os.geteuid() == 0 else []
    for argument in ["--headless=new", "--disable-gpu", "--disable-dev-shm-usage", "--window-size=1300,860", *root]:
        options.add_argument(argument)
    return Chrome(options, ChromeService(shutil.which("chromedriver")))


def start_up(driver, url):
    """Return milliseconds from the start of navigation to the first picture."""
    driver.get("about:blank")
    driver.get(url)
    while (drawn := driver.execute_script(f"return {MARK}")) is None:
        time.sleep(0.01)
    return drawn


def bytes_without_data(page):
    """Return the size of a page's markup, styles and scripts."""
    return page.n_bytes - len(re.search(r'id="data">([^<]*)<', page.html)[1].encode())
