"""The interactive page in a real browser: headless Chromium without a network, driven through ChromeDriver."""

import contextlib
import io
import json
import os
import re
import shutil
import time
from dataclasses import replace

import numpy as np
import pytest
from helpers import flat_tube

import lbskel
from lbskel.pipeline.viewing import view_scene
from lbskel.shapes import make
from lbskel.visualization import Scene, Table, page

CHROMIUM, DRIVER = shutil.which("chromium"), shutil.which("chromedriver")
pytestmark = pytest.mark.skipif(
    not (CHROMIUM and DRIVER), reason="there is no Chromium (apt-get install chromium chromium-driver)"
)
# in a small window, which is drawn sooner, and is wide enough for the controls to be beside the view
FLAGS = """--headless=new --no-sandbox --use-angle=swiftshader --enable-unsafe-swiftshader --disable-quic --no-first-run
--disable-background-networking --disable-component-update --disable-sync --window-size=900,900"""
HOSTILE = '<img src=x onerror="window.hacked=1"></script><script>window.hacked=1</script>{{}}\'&.off'
PATIENCE = 120  # seconds after which a page that is not ready never will be


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    webdriver = pytest.importorskip("selenium.webdriver", reason="selenium drives the browser: pip install selenium")
    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    for flag in [*FLAGS.split(), f"--user-data-dir={tmp_path_factory.mktemp('profile')}"]:
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(DRIVER, log_output=os.devnull))
    yield driver
    driver.quit()


@pytest.fixture(scope="module")
def scene():
    """A shape with five limbs, a hole that was closed, a name that is a program, and hostile notes."""
    mesh = make("octopus", n_vertices=600).mesh
    middle = mesh.vertices[mesh.faces].mean(axis=1)
    holed = lbskel.Mesh(mesh.vertices, mesh.faces[np.linalg.norm(middle - middle[0], axis=1) > 0.1])
    skeleton = lbskel.skeletonize(holed)
    hostile = replace(skeleton, report={**skeleton.report, "notes": [HOSTILE]})
    scene = view_scene(holed, hostile, title=HOSTILE)
    tables = [*scene.tables, Table(HOSTILE, [HOSTILE], [[HOSTILE]])]
    return replace(scene, notes=[HOSTILE], tables=tables, off_center=skeleton.junctions[:1])


def opened(browser, path):
    """Open a file and wait until it is drawn."""
    browser.get(path.as_uri())
    end = time.monotonic() + PATIENCE
    while not browser.execute_script("return document.body.dataset.ready"):
        assert time.monotonic() < end, browser.get_log("browser")
        time.sleep(0.05)


@contextlib.contextmanager
def resized(browser, width):
    """A screen of another width."""
    size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    yield
    browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


LOOK = """
const mark = performance.mark;
performance.mark = function (name) {
  if (name === "drawn") {
    window.first = document.getElementById("view").data.filter((t) => t.visible).map((t) => t.mode || t.type);
    document.getElementById("show-tips").click();
  }
  return mark.apply(performance, arguments);
};"""


@pytest.fixture(scope="module")
def at_first(browser, scene, tmp_path_factory):
    """Opens the page: what its first frame shows, and which markers come after it if tips are switched off then."""
    path = tmp_path_factory.mktemp("pages") / "page.html"
    page(scene, path)
    added = browser.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": LOOK})
    try:
        opened(browser, path)
    finally:
        browser.execute_cdp_cmd("Page.removeScriptToEvaluateOnNewDocument", added)
    markers = browser.execute_script(
        "return document.getElementById('view').data.filter((t) => t.mode === 'markers').map((t) => t.visible)"
    )
    browser.execute_script("document.getElementById('show-tips').click()")
    settled(browser)
    return browser.execute_script("return window.first"), markers


@pytest.fixture(scope="module")
def shown(browser, at_first):
    """The browser with the page, all of whose markers are shown."""
    return browser


def traces(browser):
    """Type, visibility and first coordinates of what is drawn."""
    return json.loads(
        browser.execute_script(
            "return JSON.stringify(document.getElementById('view').data.map((t) => ({type: t.type, visible: t.visible, "
            "x: Array.from(t.x).slice(0, 50), n: t.x.length, color: t.color})))"
        )
    )


def picture(browser, name="view"):
    """The pixels of an element, as the screen shows them."""
    from PIL import Image

    with Image.open(io.BytesIO(browser.find_element("id", name).screenshot_as_png)) as image:
        return np.asarray(image.convert("RGB")).astype(int)


def settled(browser):
    """Wait for two frames."""
    browser.execute_async_script("const done = arguments[0]; requestAnimationFrame(() => requestAnimationFrame(done))")


def test_the_page_is_drawn_without_errors(shown):
    pixels = picture(shown)
    assert (np.abs(pixels - pixels[2, 2]).sum(axis=2) > 30).mean() > 0.02  # not blank
    assert len(picture(shown, "curves")) > 100
    assert [entry for entry in shown.get_log("browser") if entry["level"] == "SEVERE"] == []


def test_a_picture_comes_before_the_programs_and_goes_when_the_view_is_drawn(shown):
    marks = shown.execute_script("return performance.getEntriesByType('mark').map((each) => each.name)")
    assert marks == ["picture", "library", "decoded", "drawn"]
    assert shown.find_elements("id", "poster") == []


def test_markers_come_after_the_first_frame_as_their_toggles_are_then(at_first):
    """The first frame has surface and lines, which is what costs little; a toggle in between is heeded."""
    first, markers = at_first
    assert first == ["mesh3d", "lines", "lines"]  # of the chosen branch too
    assert markers == [False, True, False, True, False]  # mended, nodes, tips, junctions, off-center


def test_nothing_can_be_uploaded(shown):
    titles = shown.execute_script(
        "return Array.from(document.querySelectorAll('.modebar-btn'), (each) => each.dataset.title)"
    )
    assert titles
    assert not [title for title in titles if re.search("share|cloud|edit", title, re.I)]


def test_hostile_names_and_notes_are_text(shown):
    assert shown.execute_script("return window.hacked") is None
    assert shown.find_element("tag name", "h1").text == HOSTILE
    assert shown.title == HOSTILE
    texts = shown.execute_script(
        "return Array.from(document.querySelectorAll('p, td, th, caption'), (e) => e.textContent)"
    )
    assert texts.count(HOSTILE) == 5  # paragraph, note of the report, caption, heading, row
    assert shown.execute_script("return document.querySelectorAll('img').length") == 0


def test_the_slider_moves_the_vertices(shown, scene):
    slider = shown.find_element("id", "step")
    before = traces(shown)
    contracted = [t.get("color") for t in before].index("#4c78a8")
    assert before[contracted]["visible"] is False
    for step in (1, len(scene.positions)):
        while int(slider.get_attribute("value")) < step:
            slider.send_keys("\ue014")  # the right arrow
        settled(shown)
        now = traces(shown)[contracted]
        assert now["visible"] is True
        assert now["n"] == len(scene.contracted.vertices)
        assert shown.find_element("id", "step-text").text.startswith(f"step {step} of {len(scene.positions)}: area")
        assert slider.get_attribute("aria-valuetext") == shown.find_element("id", "step-text").text
        assert np.abs(np.subtract(now["x"], before[contracted]["x"])).max() > 0.01
        before[contracted] = now
    line = shown.execute_script("return document.getElementById('curves').layout.shapes[0].x0")
    assert line == len(scene.positions)


def test_every_toggle_hides_and_shows_its_layer(shown):
    boxes = shown.find_elements("css selector", "input[data-layer]")
    names = [box.get_attribute("data-layer") for box in boxes]
    assert names == ["mesh", "skeleton", "tips", "junctions", "balls", "parts", "contracted", "off_center", "mended"]
    for box in boxes:
        visible = [[trace["visible"] for trace in traces(shown)]]
        for _ in range(2):
            box.click()
            settled(shown)
            visible.append([trace["visible"] for trace in traces(shown)])
        assert visible[0] != visible[1], box.get_attribute("data-layer")
        assert visible[0] == visible[2]


def test_a_branch_that_is_chosen_shows_its_row(shown, scene):
    choice = shown.find_element("id", "branch")
    choice.send_keys("2")
    rows = shown.find_elements("css selector", "#branch-rows tr")
    table = {row.find_element("tag name", "th").text: row.find_element("tag name", "td").text for row in rows}
    assert list(table) == list(scene.columns)
    assert table["branch"] == "2"
    assert float(table["length"]) == pytest.approx(scene.columns["length"][2], rel=0.01)
    assert traces(shown)[-1]["n"] == len(scene.skeleton.branches[2])


def pointed_at(browser, place):
    """Move the mouse to a place in the window."""
    from selenium.webdriver.common.action_chains import ActionChains

    chain = ActionChains(browser, duration=20)
    chain.w3c_actions.pointer_action.move_to_location(*place)
    chain.perform()


def clicked(browser, seconds):
    """Press the button of the mouse where it is, for so long."""
    from selenium.webdriver.common.action_chains import ActionChains

    ActionChains(browser, duration=20).click_and_hold().pause(seconds).release().perform()


def places_of_skeleton(browser):
    """Places in the window where the skeleton is seen through the mesh: what its toggle changes."""
    from PIL import Image

    browser.execute_script("window.scrollTo(0, 0)")
    pictures = []
    for _ in range(2):
        browser.execute_script("document.getElementById('show-skeleton').click()")
        settled(browser)
        with Image.open(io.BytesIO(browser.get_screenshot_as_png())) as image:
            pictures.append(np.asarray(image.convert("RGB")).astype(int))
    view = browser.execute_script("return document.getElementById('view').getBoundingClientRect().toJSON()")
    rows, columns = np.nonzero(np.abs(pictures[1] - pictures[0]).sum(axis=2) > 150)
    is_in_view = (columns > view["left"]) & (columns < view["left"] + 0.85 * view["width"])  # not the bar of colors
    is_in_view &= (rows > view["top"]) & (rows < view["bottom"])
    return np.column_stack([columns, rows])[is_in_view]


def wait_for(browser, program):
    """What a program returns, as soon as that is something."""
    end = time.monotonic() + PATIENCE
    while not (value := browser.execute_script(f"return {program}")):
        assert time.monotonic() < end, program
        time.sleep(0.05)
    return value


def test_the_mouse_on_the_skeleton_shows_the_node_and_a_click_its_branch(shown, scene):
    """With a real mouse, through the mesh in front; again and again, since a click could stop all drawing.

    A long press, during which the view is drawn again, and a short one.
    """
    places = places_of_skeleton(shown)
    assert len(places) > 200
    branches = scene.skeleton.branches
    for number, place in enumerate(places[:: len(places) // 2].tolist()):
        shown.execute_script("document.getElementById('branch').value = '-1'")
        for where in ((5, 5), (place[0] + 3, place[1] + 3), place):
            pointed_at(shown, where)
            settled(shown)
        label = wait_for(shown, "(document.querySelector('#view .hovertext') || {}).textContent")
        node, radius = (
            int(re.match(r"node (\d+)", label)[1]),
            float(re.search(r"inscribed radius ([\d.]+)\(", label)[1]),
        )
        assert radius == pytest.approx(scene.skeleton.radii[node], rel=1e-3)
        position = [float(number) for number in label.rpartition("(")[2].rstrip(")").split(",")]
        assert position == pytest.approx(scene.skeleton.nodes[node], rel=1e-5, abs=1e-5)
        clicked(shown, 0.5 * (number % 2))
        if node not in scene.skeleton.junctions:
            [branch] = [row for row, nodes in enumerate(branches) if node in nodes]
            assert f"branch {branch}i" in label
            wait_for(shown, f"document.getElementById('branch').value === '{branch}'")
            assert shown.find_element("css selector", "#branch-rows td").text == str(branch)


def test_everything_can_be_reached_by_keyboard_and_has_a_name(shown):
    nameless = shown.execute_script(
        "return Array.from(document.querySelectorAll('main input, main select, main button, main [tabindex]'))"
        ".filter((e) => !(e.labels && e.labels.length) && !e.getAttribute('aria-label') && !e.textContent.trim())"
        ".filter((e) => !e.closest('#view .plot-container') && !e.closest('#curves')).map((e) => e.outerHTML)"
    )
    assert nameless == []
    assert "skeleton has" in shown.find_element("id", "view").get_attribute("aria-label")


def test_a_screen_reader_meets_no_picture_and_no_control_without_a_name(shown):
    nodes = shown.execute_cdp_cmd("Accessibility.getFullAXTree", {})["nodes"]
    roles = ("image", "button", "checkbox", "slider", "combobox", "region", "table")
    named = [
        (node["role"]["value"], node.get("name", {}).get("value"))
        for node in nodes
        if not node["ignored"] and node["role"]["value"] in roles
    ]
    assert {role for role, _ in named} == set(roles)
    assert [role for role, name in named if not name] == []
    assert len([role for role, _ in named if role == "image"]) == 2  # the view and the curves


def test_the_view_is_turned_and_zoomed_by_keys(shown):
    """Four arrows of 10 degrees each bring the camera around by 40 degrees, and back."""

    def camera():
        found = shown.execute_script("return document.getElementById('view')._fullLayout.scene._scene.getCamera()")
        return np.array([[found[name][axis] for axis in "xyz"] for name in ("eye", "up")])

    view, start = shown.find_element("id", "view"), camera()
    far = np.linalg.norm(start[0])
    for forth, back, other in (("\ue014", "\ue012", 1), ("\ue013", "\ue015", 0)):  # right and left, up and down
        view.send_keys(forth * 4)
        settled(shown)
        eye, up = camera()
        assert eye @ start[0] / far**2 == pytest.approx(np.cos(np.radians(40)), abs=1e-3)  # plotly's rounding
        assert np.linalg.norm(eye) == pytest.approx(far, rel=1e-3)
        assert up @ eye == pytest.approx(0, abs=1e-3)
        assert eye[other] == pytest.approx(start[0][other], abs=1e-3)
        view.send_keys(back * 4)
        settled(shown)
        np.testing.assert_allclose(camera(), start, atol=1e-3)
    view.send_keys("+")
    settled(shown)
    assert np.linalg.norm(camera()[0]) == pytest.approx(far / 1.1, rel=1e-3)
    view.send_keys("-")
    settled(shown)


@pytest.mark.parametrize("width", [400, 1400])
def test_nothing_is_cut_off_on_a_narrow_or_dark_screen(shown, width):
    """The page is no wider than the window; the colors follow the system."""
    backs = []
    with resized(shown, width):
        for scheme in ("dark", "light"):
            features = {"features": [{"name": "prefers-color-scheme", "value": scheme}]}
            shown.execute_cdp_cmd("Emulation.setEmulatedMedia", features)
            settled(shown)
            backs.append(picture(shown)[4, 4].sum())
            assert shown.execute_script("return document.documentElement.scrollWidth") <= width
    assert backs[0] < 120
    assert backs[1] > 740


def test_markers_of_many_branches_do_not_hide_them(browser, tmp_path):
    angles = np.linspace(0, 6, 800)
    ends = np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])
    star = lbskel.Skeleton(np.vstack([[0, 0, 0], ends]), [[0, k] for k in range(1, 801)], np.full(801, 0.01))
    page(Scene(skeleton=star), tmp_path / "star.html")
    with resized(browser, 1400):  # markers are smaller on a small screen too
        opened(browser, tmp_path / "star.html")
    sizes = browser.execute_script(
        "return document.getElementById('view').data.filter((t) => t.mode === 'markers' && t.x.length)"
        ".map((t) => t.marker.size)"
    )
    assert max(sizes) < 3


@pytest.fixture(scope="module")
def attacked(browser, tmp_path_factory):
    """The browser with the page of a field of hostile name, into which a program and a picture were put."""
    mesh, path = flat_tube(), tmp_path_factory.mktemp("pages") / "field.html"
    page(Scene(mesh, field=mesh.vertices[:, 0], field_name=HOSTILE), path)
    text = path.read_text()
    assert text.count("</h1>") == 1
    path.write_text(text.replace("</h1>", "</h1><script>window.hacked=1</script><img src='http://0.0.0.0/x.png'>"))
    browser.get_log("browser")
    opened(browser, path)
    return browser


def test_a_field_is_shown_as_color(attacked):
    shown = [trace for trace in traces(attacked) if trace["visible"]]
    assert [trace["type"] for trace in shown] == ["mesh3d"]
    colors = picture(attacked)[::8, ::8].reshape(-1, 3)
    assert len({tuple(color) for color in (colors // 32).tolist()}) > 5


def test_a_hostile_program_in_the_page_would_not_run(attacked):
    """The policy of the page is there, and the browser follows it."""
    assert attacked.execute_script("return window.hacked") is None
    refused = [entry["message"] for entry in attacked.get_log("browser") if entry["level"] == "SEVERE"]
    assert len(refused) == 2
    assert all("Content Security Policy" in message for message in refused)
