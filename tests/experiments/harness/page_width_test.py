#!/usr/bin/env python3
"""The page of studies in a browser: page_width_test.py MSS FOLDER. No part of it is wider than the screen, of a telephone
or of a desk, and its pictures are there. The page is made from the committed results. Exit status 77, which CTest takes
for "skipped", where there is no Chromium or no gnuplot."""

import json
import pathlib
import re
import shutil
import subprocess
import sys

WIDTHS = 360, 768, 1280  # [px]

# Chromium makes no window narrower than 500 px, so the page is shown in a frame.
FRAME = """<!DOCTYPE html><html><body><iframe id="page" src="{page}" style="width: {width}px; height: 800px; border: 0"></iframe>
<script>onload = () => {{
  const page = document.getElementById('page').contentDocument, root = page.documentElement;
  page.querySelectorAll('details').forEach(d => d.open = true);
  const ids = [...page.querySelectorAll('[href^="#"]')].map(a => a.getAttribute('href').slice(1));
  document.body.textContent = JSON.stringify({{
    width: root.clientWidth, needed: root.scrollWidth, pictures: page.querySelectorAll('figure svg image').length,
    lost: ids.filter(id => !page.getElementById(id)),
    small: [...page.querySelectorAll('figure svg, .cards svg')].filter(s => s.getBoundingClientRect().width < 100).length }});
}}</script></body></html>"""


def measure(browser, page, width, folder):
    frame = folder / f"frame_{width}.html"
    frame.write_text(FRAME.format(page=page.name, width=width))
    command = [browser, "--headless", "--no-sandbox", "--disable-gpu", "--allow-file-access-from-files",
               f"--user-data-dir={folder / 'profile'}", "--window-size=1400,900", "--virtual-time-budget=10000",
               "--dump-dom", frame.resolve().as_uri()]
    dom = subprocess.run(command, capture_output=True, text=True, timeout=600, check=True).stdout
    return json.loads(re.search(r"\{.*\}", dom).group())


def main():
    program, folder = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    browser = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    for name, found in ("Chromium", browser), ("gnuplot", shutil.which("gnuplot")):
        if not found:
            print(f"skipped: {name} is not installed")
            return 77
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(pathlib.Path(__file__).parents[3] / "results", folder)
    subprocess.run([program, "redraw", folder], check=True, stdout=subprocess.DEVNULL)
    page, failures = folder / "index.html", 0
    drawn = page.read_text().count("<figure ")
    for width in WIDTHS:
        seen = measure(browser, page, width, folder)
        print(f"{width} px: {seen}")
        failures += (seen["width"] < width - 20 or seen["needed"] > seen["width"] or seen["pictures"] != drawn
                     or seen["lost"] != [] or seen["small"] > 0)
    return 1 if failures or drawn < 17 else 0


sys.exit(main())
