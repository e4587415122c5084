"""A page in a headless Chromium, and checks of pages, for tests/report/report_browser.py and tests/long/splat_viewer.py."""
import json
import os
import socket

from selenium import webdriver
from selenium.common.exceptions import WebDriverException
from selenium.webdriver.chrome.options import Options
from selenium.webdriver.chrome.service import Service

# Selenium calls its driver by the name localhost, which a minimal system without /etc/hosts does not know. For the same reason the driver
# speaks with the browser through a pipe.
resolve = socket.getaddrinfo
socket.getaddrinfo = lambda host, *rest, **more: resolve('127.0.0.1' if host == 'localhost' else host, *rest, **more)


def start_browser(folder, *more):
    options = Options()
    options.binary_location = os.environ.get('CHROMIUM', '/usr/bin/chromium')
    for argument in ('--headless=new', '--no-sandbox', '--disable-gpu', '--disable-dev-shm-usage', '--no-first-run', '--hide-scrollbars',
                     '--disable-background-networking', '--remote-debugging-pipe', f'--user-data-dir={folder}/browser', *more):
        options.add_argument(argument)
    options.set_capability('goog:loggingPrefs', {'browser': 'ALL', 'performance': 'ALL'})
    return webdriver.Chrome(service=Service(os.environ.get('CHROMEDRIVER', '/usr/bin/chromedriver')), options=options)


class Page:
    """A report in the browser."""

    def __init__(self, browser, path, width_px=1280):
        self.browser, self.path = browser, path
        browser.execute_cdp_cmd('Emulation.setEmulatedMedia', {'media': ''})
        self.resize(width_px)
        browser.get_log('browser'), browser.get_log('performance') # those of the page before
        browser.get('file://' + path)

    def resize(self, width_px):
        self.browser.execute_cdp_cmd('Emulation.setDeviceMetricsOverride', {'width': width_px, 'height': 900, 'deviceScaleFactor': 1,
                                                                           'mobile': width_px < 600})

    def run(self, script, *arguments):
        return self.browser.execute_script(script, *arguments)

    def errors(self):
        return [entry['message'] for entry in self.browser.get_log('browser') if entry['level'] in ('SEVERE', 'WARNING')]

    def requests(self):
        """What was asked for beside the file itself."""
        events = [json.loads(entry['message'])['message'] for entry in self.browser.get_log('performance')]
        urls = [event['params']['request']['url'] for event in events if event['method'] == 'Network.requestWillBeSent']
        own = ('data:', 'chrome:', 'chrome-untrusted:')  # the browser's own pages, which other tabs may load, ask for these
        return [url for url in urls if not url.startswith(own) and url != 'file://' + self.path]

    def ranking(self, column=1):
        cell = f'#ranking-table tbody tr td:nth-child({column + 1})'
        return self.run(f"""return [...document.querySelectorAll('{cell}')]
            .map(one => (one.querySelector('.photo div') || one).firstChild.textContent)""")

    def choose(self, box, value):
        self.run("const box = document.getElementById(arguments[0]); box.value = arguments[1]; box.dispatchEvent(new Event('change'))",
                 box, value)

    def type(self, box, text):
        self.run("const box = document.getElementById(arguments[0]); box.value = arguments[1]; box.dispatchEvent(new Event('input'))",
                 box, text)

    def click_head(self, title):
        self.run("[...document.querySelectorAll('#ranking-table th button')].find(one => one.textContent.startsWith(arguments[0])).click()",
                 title)


CHECKS = []


def check(what):
    def add(function):
        CHECKS.append((what, function))
        return function
    return add


def expect(condition, why):
    if not condition:
        raise AssertionError(why)


def run_checks(folder):
    """Prints a line per check: "ok WHAT" or "failed WHAT: why"; or "no browser WHY" where it cannot be started."""
    try:
        browser = start_browser(folder)
    except WebDriverException as error:
        print('no browser', str(error).split('Stacktrace')[0].replace('\n', ' '))
        return
    try:
        for what, function in CHECKS:
            try:
                function(browser, folder)
                print('ok', what)
            except Exception as error: # whatever a page does, the other checks go on
                print('failed', f'{what}: {type(error).__name__}: {str(error)[:1500]}'.replace('\n', ' '))
    finally:
        browser.quit()
