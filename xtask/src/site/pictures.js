// A picture opens alone, as large as the window has room for.
for (const picture of document.querySelectorAll("article img")) {
  if (picture.closest("a")) continue;
  const link = Object.assign(document.createElement("a"), { href: picture.src, title: "open the picture alone" });
  picture.replaceWith(link);
  link.append(picture);
}
// What is wider than the page can be scrolled by keys, too.
for (const code of document.querySelectorAll("pre")) code.tabIndex = 0;
