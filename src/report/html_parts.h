// The files of the page, as the build put them into the program (src/report/embed.cmake).
#ifndef VIEWWORTH_REPORT_HTML_PARTS_H
#define VIEWWORTH_REPORT_HTML_PARTS_H

// report.html: {{policy}}, {{style}}, {{chart}}, {{widgets}}, {{script}}, {{tradeoff}}, {{photos}},
// {{scores}}, {{tables}}, {{extra}} and {{data}} stand for the rest
extern const char vw_html_template[];
extern const char vw_html_style[];    // report.css
extern const char vw_html_chart[];    // Chart.js
extern const char vw_html_widgets[];  // report_widgets.js
extern const char vw_html_script[];   // report.js
extern const char vw_html_tradeoff[]; // report_tradeoff.js
extern const char vw_html_photos[];   // report_photos.js
extern const char vw_html_scores[];   // report_scores.js
extern const char vw_html_tables[];   // report_tables.js
extern const char vw_html_next[];     // report_next.js, a part of {{extra}} where there are places for the next photos

#endif
