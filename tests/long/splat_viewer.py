"""Shows splats in a viewer in a headless Chromium, for test_splat_viewers.sh:

    splat_viewer.py FOLDER FRAMES BLUR FILE...    with FOLDER/node_modules and splat_viewer.html, as that script makes them

FOLDER/FRAMES.json is a camera path of nerfstudio, and frame_0001.png in the folder FRAMES beside it what `viewworth render` made of it.
The viewer adds BLUR square pixels to splats, by itself 0.3.
Prints a line per FILE in FOLDER: its name, the number of its splats, the PSNR in dB between the viewer's picture and the render, and the
mean square of the render; or "no browser WHY" where it cannot be started.
"""
import functools
import http.server
import json
import os
import sys
import threading

from selenium.common.exceptions import WebDriverException

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), '../support'))
sys.dont_write_bytecode = True  # the source folder stays as it is
from browser_page import start_browser

LIMIT_S = 300  # WebGL on a CPU that others keep busy


class Handler(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


def serve(folder):
    """Starts a server of a folder for this machine alone: a page from a file may not load modules."""
    server = http.server.ThreadingHTTPServer(('127.0.0.1', 0), functools.partial(Handler, directory=folder))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    return f'http://127.0.0.1:{server.server_port}'


def compare(browser, address, file, frames, path, blur):
    browser.get(f'{address}/splat_viewer.html')  # anew for each file
    try:
        answer = browser.execute_async_script(
            "const done = arguments[4]; compare(...[...arguments].slice(0, 4)).then(done, why => done(String(why)))",
            f'/{file}', f'/{frames}/frame_0001.png', path, blur)
    except WebDriverException as error:
        answer = error.msg
    if not isinstance(answer, list):
        raise SystemExit(f'{file}: {answer}: {browser.get_log("browser")}')
    count, psnr_db, light = answer
    print(file, count, f'{psnr_db:.1f} {light:.3f}', flush=True)


def main():
    folder, frames, blur, *files = sys.argv[1:]
    with open(os.path.join(folder, f'{frames}.json'), encoding='utf-8') as file:
        path = json.load(file)
    try:
        browser = start_browser(folder, '--use-angle=swiftshader', '--enable-unsafe-swiftshader')
    except WebDriverException as error:
        print('no browser', str(error).splitlines()[0])
        return
    try:
        browser.set_script_timeout(LIMIT_S)
        address = serve(folder)
        for file in files:
            compare(browser, address, file, frames, path, float(blur))
    finally:
        browser.quit()


main()
