"""The page at a gateway that asks for tokens, over TLS: pasted, in the address, and kept for the tab."""

from pathlib import Path

import pytest
from playwright.async_api import Browser, Page, expect

from tests.support.certificates import Authority
from tests.support.guarded import fresh, guarded

pytestmark = [pytest.mark.browser, pytest.mark.asyncio(loop_scope="session")]


async def connected(page: Page) -> None:
    await expect(page.get_by_test_id("connection")).to_have_attribute("data-state", "connected")


async def test_token_is_asked_for_and_kept_over_tls(browser: Browser, tmp_path: Path) -> None:
    cert, key = Authority(tmp_path).issue()
    revoked = tmp_path / "revoked"
    revoked.write_text("")
    async with guarded(tmp_path, tls_cert=cert, tls_key=key, auth_revocations=revoked) as coming:
        async with await browser.new_context(ignore_https_errors=True) as context:
            page = await context.new_page()
            requested: list[str] = []
            page.on("request", lambda request: requested.append(request.url))
            await page.goto(coming.gateway.url)
            form, field = page.get_by_test_id("token-form"), page.get_by_test_id("token")
            await expect(form).to_be_visible()
            await field.fill("nonsense")
            await field.press("Enter")
            await expect(form).to_be_visible()
            token = fresh(roles="viewer")
            await field.fill(token)
            await field.press("Enter")
            await connected(page)
            await expect(form).to_be_hidden()
            await page.reload()
            await connected(page)
            assert token not in "".join(requested)
        async with await browser.new_context(ignore_https_errors=True) as context:
            page = await context.new_page()
            soon = fresh(roles="viewer", jti="soon")
            await page.goto(f"{coming.gateway.url}#token={soon}")
            await connected(page)
            assert await page.evaluate("location.href") == coming.gateway.url
            revoked.write_text("jti soon\n")
            # When it has ended the page asks for another one.
            await expect(page.get_by_test_id("token-form")).to_be_visible()
            await page.goto(f"{coming.gateway.url}#token={fresh()}")
            await connected(page)
