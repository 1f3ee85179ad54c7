// Steps of a visitor's fit.
import assert from "node:assert/strict";

export const CYLINDER = "PneumaticServoCylinder";
export const RIG = new URL("../../examples/rig.csv", import.meta.url);
/** Estimated parameters of the rig in the documentation. */
export const FREE = ["Fs", "Fc", "vs", "sigma2"].map((name) => `friction.stribeck.${name}`).concat("valve.deadZone", "valve.C");
/** The page on which they are to be fitted. */
export const LINK = `#view=fit&experiment=rig&free=${FREE.join("+")}&${CYLINDER}.friction.law=7&${CYLINDER}.supplyPressure=600000`;

/** Drops a text as a file on the page. */
export async function drop(page, name, text, on = ".drop") {
  const data = await page.evaluateHandle(
    ([file, content]) => {
      const transfer = new DataTransfer();
      transfer.items.add(new File([content], file, { type: "text/csv" }));
      return transfer;
    },
    [name, text],
  );
  await page.dispatchEvent(on, "drop", { dataTransfer: data });
}

export const button = (page) => page.getByRole("button", { name: "Fit or cancel" });

/** The field of an option. */
export const option = (page, name) => page.locator(".options").getByLabel(name, { exact: true });

/** Starts the fit; returns values and intervals by name. */
export async function fitted(page) {
  await button(page).click();
  await page.waitForSelector("[data-result], [data-problem]");
  assert.deepEqual(await page.locator("[data-problem]").allTextContents(), []);
  const rows = await page.locator("tr[data-name]").evaluateAll((all) => all.map(({ dataset }) => ({ ...dataset })));
  return new Map(rows.map(({ name, value, low, high }) => [name, { value: Number(value), low: Number(low), high: Number(high) }]));
}
