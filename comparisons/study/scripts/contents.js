// Contents: the link to the section in sight is marked.

function followSections(nav) {
  const links = new Map();
  for (const link of nav.querySelectorAll('a[href^="#"]')) {
    links.set(document.getElementById(link.hash.slice(1)), link);
  }
  const mark = () => {
    let current = null;
    for (const section of links.keys()) {
      if (section && section.getBoundingClientRect().top < 0.35 * innerHeight) current = section;
    }
    for (const [section, link] of links) {
      const here = section === current;
      if (here === link.hasAttribute("aria-current")) continue;
      link.toggleAttribute("aria-current", here);
      if (here) nav.firstElementChild.scrollTo({ left: link.offsetLeft - 24 });
    }
  };
  addEventListener("scroll", mark, { passive: true });
  mark();
}
