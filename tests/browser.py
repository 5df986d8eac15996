"""A page in headless Chromium: Debian's chromium with its driver (``chromium-driver``)."""

import contextlib
import shutil
import time

import pytest

PATIENCE = 600
"""Longest time, s, to wait for the browser."""

ROOMS = {
    "desktop": (1366, 768), "wide": (1920, 1080), "large": (2560, 1440), "phone": (390, 844),
    "small phone": (360, 740),
}  # fmt: skip


@contextlib.contextmanager
def opened(page, ready=None):
    """A driver that shows the page, with its log of requests; skips where there is no browser.

    ``ready`` waits until a page is drawn that does not say so itself, see `settle`.
    """
    driver_path = shutil.which("chromedriver")
    if driver_path is None:
        pytest.skip("no chromedriver is installed")
    from selenium import webdriver
    from selenium.webdriver.chrome.remote_connection import ChromeRemoteConnection
    from selenium.webdriver.chrome.service import Service
    from selenium.webdriver.remote.client_config import ClientConfig

    options = webdriver.ChromeOptions()
    for word in (
        "headless=new", "no-sandbox", "disable-gpu", "disable-quic", "no-first-run",
        "disable-background-networking", "disable-component-update", "disable-sync",
        # Without a graphics card, WebGL is drawn by the processor.
        "disable-dev-shm-usage", "enable-unsafe-swiftshader",
    ):  # fmt: skip
        options.add_argument(f"--{word}")
    options.binary_location = shutil.which("chromium") or ""
    options.timeouts = {"script": 1000 * PATIENCE}
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    service = Service(driver_path)
    service.start()
    driver = None
    try:
        # A busy machine may need minutes to start a browser.
        url = service.service_url
        client = ClientConfig(remote_server_addr=url, timeout=PATIENCE)
        connection = ChromeRemoteConnection(remote_server_addr=url, client_config=client)
        driver = webdriver.Remote(command_executor=connection, options=options)
        driver.set_page_load_timeout(PATIENCE)
        show(driver, "desktop")
        driver.get(page.as_uri())
        (ready or settle)(driver)
        yield driver
    finally:
        if driver is not None:
            driver.quit()
        service.stop()


def show(driver, room):
    """Give the page the size of a screen."""
    width, height = ROOMS[room]
    screen = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": "phone" in room}
    command = {"cmd": "Emulation.setDeviceMetricsOverride", "params": screen}
    driver.execute("executeCdpCommand", command)


def settle(driver):
    """Wait until all that was changed is drawn."""
    wait_for(driver, "return document.body.dataset.state === 'drawn'")


def wait_for(driver, script):
    """Wait until a script returns true."""
    for _ in range(10 * PATIENCE):
        if driver.execute_script(script):
            return
        time.sleep(0.1)
    raise AssertionError(f"the page does not draw what was changed: not {script}")


def log(driver, kind):
    """Entries of a log since the last call: ``browser`` or ``performance``."""
    return driver.execute("getLog", {"type": kind})["value"]
