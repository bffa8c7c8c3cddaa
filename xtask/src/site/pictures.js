// A picture opens alone, as large as the window has room for.
for (const picture of document.querySelectorAll("article img")) {
  if (picture.closest("a")) continue;
  const link = Object.assign(document.createElement("a"), { href: picture.src, title: "open the picture alone" });
  picture.replaceWith(link);
  link.append(picture);
}
