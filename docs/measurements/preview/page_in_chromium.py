"""Uses the page of `manylight render --preview browser` in headless Chromium as a person would, and makes screenshots.

Usage: python page_in_chromium.py FOLDER SCENE [OPTIONS OF render ...]

Writes growing.png, layer.png, paused.png and done.png to FOLDER; with --light-groups, also growing_lights.png and done_lights.png. The render must take 20 s or more with several passes, for example by -m path --time 25s. Needs the Python package
playwright, and Chromium: from MANYLIGHT_BROWSER, or found by name. Without them, a note is printed and nothing is checked. MANYLIGHT names
the program; default: manylight.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile

BROWSERS = ["chromium", "chromium-browser", "google-chrome", "chromium-headless-shell"]


def tools():
    """The function that starts playwright, and the path of Chromium; None if one is missing."""
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        return None
    browser = os.environ.get("MANYLIGHT_BROWSER") or next(filter(None, map(shutil.which, BROWSERS)), None)
    return browser and (sync_playwright, browser)


def start(scene, options, image):
    """A running render and the address of its page."""
    program = os.environ.get("MANYLIGHT", "manylight")
    command = [program, "render", scene, *options, "-o", image, "--preview", "browser"]
    render = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    for line in render.stderr:
        if line.startswith("preview: "):
            return render, line.split()[1]
    sys.exit("the render has no page")


class Page:
    """What a person sees of the page."""

    def __init__(self, page):
        self.page = page

    def text(self):
        return self.page.inner_text("#progress")

    def passes(self):
        return int(re.search(r"pass (\d+)", self.text())[1])

    def wait_for(self, pattern, seconds=120):
        self.page.locator("#progress", has_text=re.compile(pattern)).wait_for(timeout=1000 * seconds)

    def mean(self):
        """Mean of the sRGB bytes of the canvas."""
        return self.page.evaluate("""() => {
            const canvas = document.querySelector("canvas");
            const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d");
            copy.drawImage(canvas, 0, 0);
            const bytes = copy.getImageData(0, 0, canvas.width, canvas.height).data;
            let sum = 0;
            for (let i = 0; i < bytes.length; i += 4) sum += bytes[i] + bytes[i + 1] + bytes[i + 2];
            return sum / (0.75 * bytes.length);
        }""")

    def set_exposure(self, stops):
        self.page.evaluate("""stops => {
            const slider = document.getElementById("exposure");
            slider.value = stops;
            slider.dispatchEvent(new Event("input"));
        }""", stops)

    def pause(self, paused):
        """Clicks at once; after the final picture there is nothing to pause."""
        self.page.evaluate("""paused => {
            const button = document.getElementById("pause");
            if ((button.getAttribute("aria-pressed") === "true") !== paused) button.click();
        }""", paused)

    def choose(self, layer):
        self.page.select_option("#layer", layer)
        self.page.wait_for_timeout(300)

    def shot(self, folder, name):
        self.page.screenshot(path=os.path.join(folder, name))

    def set_lights(self, stops):
        """Moves the sliders of all light groups."""
        self.page.evaluate("""stops => {
            for (const slider of document.querySelectorAll(".lights input[type=range]")) {
                slider.value = stops;
                slider.dispatchEvent(new Event("input"));
            }
        }""", stops)

    def wait_for_mean(self, is_reached, seconds=30):
        for _ in range(10 * seconds):
            if is_reached(self.mean()):
                return
            self.page.wait_for_timeout(100)
        sys.exit(f"the picture has the mean {self.mean()}")


def use_lights(page, folder, name):
    """Weighs the light groups, if there are any."""
    if page.page.locator(".lights").count() == 0:
        return
    rendered = page.mean()
    page.set_lights(-4)
    page.wait_for_mean(lambda mean: mean < 0.2 * rendered)
    page.set_lights(1)
    page.wait_for_mean(lambda mean: mean > rendered + 2)
    page.shot(folder, name)
    page.set_lights(0)
    page.wait_for_mean(lambda mean: abs(mean - rendered) < 2)


def use(page, folder, render):
    page.wait_for(r"pass \d+")
    first = page.passes()
    dark = page.mean()
    assert dark > 1, "the picture is black"

    page.set_exposure(2)
    assert page.mean() > dark + 5, "exposure changes nothing"
    page.set_exposure(0)

    page.wait_for(f"pass (?!{first}\\b)")
    page.shot(folder, "growing.png")
    use_lights(page, folder, "growing_lights.png")

    layers = page.page.eval_on_selector_all("#layer option", "options => options.map((option) => option.value)")
    before = page.mean()
    page.choose(layers[-1])
    page.shot(folder, "layer.png")
    assert abs(page.mean() - before) > 0.1, f"{layers[-1]} looks like the image"
    page.choose(layers[0])

    page.pause(True)
    kept, shown = page.passes(), page.mean()
    page.wait_for("has arrived")
    page.shot(folder, "paused.png")
    assert (page.passes(), page.mean()) == (kept, shown), "a paused picture changes"
    page.pause(False)
    assert page.passes() > kept, "the page does not go on"

    # The final picture with all layers stays when the program has ended, also if it came during a pause.
    page.pause(True)
    for line in render.stderr:
        sys.stderr.write(line)
    assert render.wait() == 0
    page.page.wait_for_timeout(500)
    page.pause(False)
    page.wait_for("^done")
    for layer in layers:
        page.choose(layer)
        assert page.page.input_value("#layer") == layer and page.mean() >= 0
    page.choose(layers[0])
    page.shot(folder, "done.png")
    use_lights(page, folder, "done_lights.png")
    return layers


def main():
    folder, scene, *options = sys.argv[1:]
    found = tools()
    if not found:
        print("skipped: no playwright or no Chromium here")
        return
    playwright, browser = found
    with tempfile.TemporaryDirectory() as images, playwright() as play:
        render, address = start(scene, options, os.path.join(images, "image.exr"))
        chromium = play.chromium.launch(executable_path=browser)
        page = chromium.new_page(viewport={"width": 1200, "height": 900})
        problems = []
        page.on("console", lambda message: problems.append(message.text))
        page.on("pageerror", lambda error: problems.append(str(error)))
        # A stream of events is aborted when another layer is chosen.
        page.on("requestfailed", lambda request: "ABORTED" in request.failure or problems.append(request.failure))
        try:
            page.goto(address)
            layers = use(Page(page), folder, render)
        finally:
            render.kill()
            chromium.close()
    assert not problems, problems
    print(f"the page works; layers: {', '.join(layers)}")


if __name__ == "__main__":
    main()
