//! Lines of JSON between a worker and whoever employs it.
//!
//! Each line in is a [`Message`]; each gets one [`Answer`] with its `id`, in the order in which the work
//! ends, beside news of requests that asked for them.

use super::{Failure, Outcome, Request};
use serde::de::{Error, IgnoredAny, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::Value;
use std::fmt;

/// A line to the worker: an object with an `id` and one order.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Message {
    /// Comes back with the answer; any JSON value.
    pub id: Value,
    /// What to do.
    #[serde(flatten)]
    pub order: Order,
}

/// What to do.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Order {
    /// `{"id": 1, "slice": {"model": "a.stl", "output": "a.gcode"}}`
    Slice(Box<Request>),
    /// The same, with news on the way.
    Follow(Box<Request>),
    /// `{"id": 2, "cancel": 1}`: the request with that id is to stop; it is answered as cancelled.
    Cancel(Value),
    /// `{"id": 3, "ping": null}`
    Ping(()),
    /// No more requests: what is in hand is finished, this is answered, then the worker ends. The end of its
    /// input means the same, without an answer.
    Quit(()),
}

/// A line from the worker.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Answer {
    /// The message's.
    pub id: Value,
    /// What there is to say.
    #[serde(flatten)]
    pub news: News,
}

/// What a worker says.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum News {
    /// First line of all, with `"id": null`.
    Ready {
        /// The program's version.
        version: String,
        /// The process.
        pid: u32,
    },
    /// Work on a followed request begins.
    Started(()),
    /// A stage of a followed request begins.
    Stage(String),
    /// A request is done.
    Done(Box<Outcome>),
    /// A request failed.
    Failed(Failure),
    /// To a ping, to a cancel that found its request, and to a quit when all else is answered.
    Ok(()),
    /// The line was not understood; `id` is null where it could not be read.
    Refused(String),
}

impl Message {
    /// Reads a line.
    ///
    /// # Errors
    /// The answer that refuses it, with the line's id where it has one.
    pub fn read(line: &[u8]) -> Result<Self, Answer> {
        serde_json::from_slice(line).map_err(|error| {
            let object = serde_json::from_slice::<Value>(line).unwrap_or_default();
            let id = object.get("id").cloned().unwrap_or_default();
            Answer { id, news: News::Refused(error.to_string()) }
        })
    }
}

/// The names of orders.
const ORDERS: [&str; 5] = ["slice", "follow", "cancel", "ping", "quit"];

// By hand, because serde lets unknown fields pass beside flattened ones.
impl<'de> Deserialize<'de> for Message {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Fields;
        impl<'de> Visitor<'de> for Fields {
            type Value = Message;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an object with an id and an order, such as {\"id\": 1, \"ping\": null}")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Message, A::Error> {
                let (mut id, mut order) = (None, None);
                while let Some(key) = map.next_key::<String>()? {
                    if key == "id" {
                        if id.replace(map.next_value()?).is_some() {
                            return Err(A::Error::duplicate_field("id"));
                        }
                        continue;
                    }
                    if let Some((before, _)) = order.filter(|_| ORDERS.contains(&key.as_str())) {
                        return Err(A::Error::custom(format!(
                            "two orders in one line, `{before}` and `{key}`"
                        )));
                    }
                    let value = match key.as_str() {
                        "slice" => Order::Slice(map.next_value()?),
                        "follow" => Order::Follow(map.next_value()?),
                        "cancel" => Order::Cancel(map.next_value()?),
                        "ping" => {
                            map.next_value::<IgnoredAny>()?;
                            Order::Ping(())
                        }
                        "quit" => {
                            map.next_value::<IgnoredAny>()?;
                            Order::Quit(())
                        }
                        other => {
                            let other = other.escape_debug();
                            return Err(A::Error::custom(format!(
                                "unknown field `{other}`, expected `id` and one of {}",
                                ORDERS.join(", ")
                            )));
                        }
                    };
                    order = Some((key, value));
                }
                let id = id.ok_or_else(|| A::Error::missing_field("id"))?;
                let (_, order) = order.ok_or_else(|| {
                    A::Error::custom(format!("there is no order in it; give one of {}", ORDERS.join(", ")))
                })?;
                Ok(Message { id, order })
            }
        }
        deserializer.deserialize_map(Fields)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::job::FailureKind;
    use serde_json::json;

    #[test]
    fn messages_survive_json() {
        let request = || Box::new(Request::new("a.stl").output("a.gcode").set("layer_height", "0.2"));
        for order in [
            Order::Slice(request()),
            Order::Follow(request()),
            Order::Cancel(json!({"a": [1]})),
            Order::Ping(()),
            Order::Quit(()),
        ] {
            let message = Message { id: json!("ü"), order };
            let line = serde_json::to_string(&message).unwrap();
            assert!(!line.contains('\n'));
            assert_eq!(Message::read(line.as_bytes()).unwrap(), message, "{line}");
        }
    }

    #[test]
    fn answers_survive_json() {
        let outcome = Outcome { bytes: 7, stages: vec![("load".to_owned(), 0.25)], ..Outcome::default() };
        for news in [
            News::Ready { version: "1".to_owned(), pid: 2 },
            News::Started(()),
            News::Stage("walls".to_owned()),
            News::Done(Box::new(outcome)),
            News::Failed(Failure::new(FailureKind::Model, "no".to_owned())),
            News::Ok(()),
            News::Refused("what?".to_owned()),
        ] {
            let answer = Answer { id: json!(3), news };
            let line = serde_json::to_string(&answer).unwrap();
            assert_eq!(serde_json::from_str::<Answer>(&line).unwrap(), answer, "{line}");
        }
    }

    #[test]
    fn wrong_lines_are_refused_with_what_is_wrong_and_their_id() {
        let refused = |line: &[u8]| match Message::read(line) {
            Err(Answer { id, news: News::Refused(why) }) => (id, why),
            other => unreachable!("{other:?}"),
        };
        for (line, id, part) in [
            (r#"{"id": 1, "slize": {}}"#, json!(1), "unknown field `slize`, expected `id` and one of slice,"),
            (
                r#"{"id": 2, "slice": {"modle": "a"}}"#,
                json!(2),
                "unknown field `modle`, expected one of `model`",
            ),
            (r#"{"id": 3, "slice": {"copies": "x"}}"#, json!(3), "expected u32"),
            (r#"{"ping": null}"#, json!(null), "missing field `id`"),
            (r#"{"id": "q"}"#, json!("q"), "there is no order in it; give one of slice"),
            (
                r#"{"id": 4, "ping": null, "quit": null}"#,
                json!(4),
                "two orders in one line, `ping` and `quit`",
            ),
            (r#"{"id": 5, "slice": {"model": "a"}"#, json!(null), "EOF"),
            ("[1]", json!(null), "expected an object with an id"),
            ("hello", json!(null), "expected value"),
            (r#"{"id": 6, "ping": null} x"#, json!(null), "trailing characters"),
        ] {
            let (found, why) = refused(line.as_bytes());
            assert!(found == id && why.contains(part) && !why.contains('\n'), "{line}: {found} {why}");
        }
        assert!(refused(b"{\"id\": \"\xff\", \"ping\": null}").1.contains("unicode"));
        assert!(refused(b"\xff\xfe").1.contains("expected value"));
    }
}
